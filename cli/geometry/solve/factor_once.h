// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/solve/factor_once.h
// A sparse direct solver that remembers its last matrix and factorizes it once.
#pragma once
#include <Eigen/SparseCore>
#include <cstddef>
#include <memory>

namespace dgm::bake {

struct SolveStatistics {
    std::size_t factorizations = 0;  ///< numeric factorizations made
    std::size_t solves = 0;          ///< right-hand sides solved
    std::size_t unsymmetric = 0;     ///< factorizations that needed LU
};

/// Solves A x = b for a square A, for a caller that passes the same A again and again, as CGAL's parameterizers do.
///
/// The matrix is compared with the last one entry by entry; only a different one is factorized. Rows that are those of
/// the identity (pinned vertices) are eliminated first. The rest is solved by LDL^T if it is symmetric up to rounding,
/// else, or if LDL^T breaks down, by LU; both with iterative refinement on the caller's own entries. Eigen's LDL^T
/// and our LU, and not SuiteSparse's, because those call the BLAS of the machine, whose rounding may depend on the
/// thread count.
/// Not thread-safe.
class FactorOnce {
 public:
    FactorOnce();
    ~FactorOnce();
    FactorOnce(const FactorOnce&) = delete;
    FactorOnce& operator=(const FactorOnce&) = delete;

    /// @return false, and x unspecified, if A is singular to working precision or anything is not finite
    [[nodiscard]] bool solve(const Eigen::SparseMatrix<double>& A, const Eigen::VectorXd& b, Eigen::VectorXd& x);
    [[nodiscard]] const SolveStatistics& statistics() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dgm::bake
