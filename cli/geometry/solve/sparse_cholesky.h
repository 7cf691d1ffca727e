// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/solve/sparse_cholesky.h
// Sparse Cholesky factorization that analyses a pattern once and works in small dense blocks.
#pragma once
#include <Eigen/SparseCore>
#include <cstddef>
#include <memory>
#include <span>

namespace dgm::bake {

/// How unknowns are ordered to keep the factor small.
enum class Ordering {
    kMinimumDegree,     ///< quick to find: for a matrix that is factorized once or twice
    kNestedDissection,  ///< a smaller factor, found more slowly: for one that is factorized again and again, and for
                        ///  large ones
};

/// A = L L^T for symmetric positive definite A: the multifrontal method [Duff, Reid 1983], [Liu 1992] over relaxed
/// supernodes. Next to a column-by-column factorization it spends its time in dense loops that the compiler vectorises:
/// the larger the matrix, the more that gains. It calls no BLAS, whose rounding could depend on the machine or the
/// number of threads: equal input, equal bits.
///
/// Unknowns may come in blocks (`block` = 2: rows 2 i and 2 i + 1 are u and v of one vertex); blocks are ordered as a
/// whole. Not thread-safe; distinct objects are independent of each other.
class SparseCholesky {
 public:
    SparseCholesky();
    ~SparseCholesky();
    SparseCholesky(SparseCholesky&&) noexcept;
    SparseCholesky& operator=(SparseCholesky&&) noexcept;

    /// Orders the unknowns and finds the structure of L.
    /// @param lower  compressed square matrix whose lower triangle (diagonal included) is the pattern; entries above it
    ///               are ignored
    /// @param block  1..8, divides the number of rows
    void analyze(const Eigen::SparseMatrix<double>& lower, Ordering ordering, int block = 1);

    /// Numeric factorization of a matrix with the very pattern given to analyze().
    /// @return false if a pivot is not positive (not definite to working precision, or not finite); solve() is then not
    ///         allowed until a factorization succeeds
    [[nodiscard]] bool factorize(const Eigen::SparseMatrix<double>& lower);

    /// Solves A X = B in place; `columns` right-hand sides of rows() numbers, one after the other. For one and the same
    /// factorization the columns are independent: each comes out as if it were solved alone.
    void solve(std::span<double> columns) const;

    [[nodiscard]] std::size_t rows() const;
    [[nodiscard]] std::size_t factor_entries() const;  ///< numbers stored in L, padding included

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dgm::bake
