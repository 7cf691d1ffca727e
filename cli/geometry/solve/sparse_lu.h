// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/solve/sparse_lu.h
// Sparse LU factorization in plain loops: the same bits on every processor.
#pragma once
#include <Eigen/SparseCore>
#include <memory>

namespace dgm::bake {

/// P A Q = L U for a square unsymmetric A, column by column [Gilbert, Peierls 1988].
///
/// Columns are ordered by minimum degree on the pattern of A + A^T. A diagonal pivot is taken wherever it is at least a
/// thousandth of the largest in its column, as in KLU [Davis, Palamadai 2010]: matrices of mean value or authalic
/// weights then keep their small fill. Refine the solution if every digit counts. Each sum has one order, so equal
/// input gives equal bits. Eigen's SparseLU does not: it solves triangles for several columns in panels whose width
/// depends on the processor's registers.
/// Not thread-safe; distinct objects are independent of each other.
class SparseLu {
 public:
    SparseLu();
    ~SparseLu();
    SparseLu(SparseLu&&) noexcept;
    SparseLu& operator=(SparseLu&&) noexcept;

    /// @param A  compressed, square
    /// @return false if a column has no usable pivot (all candidates are zero, or one is not finite); solve() is then
    ///         not allowed until a factorization succeeds
    [[nodiscard]] bool factorize(const Eigen::SparseMatrix<double>& A);

    /// The solution of A x = b; b has as many entries as A has rows.
    [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& b) const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dgm::bake
