// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/solve/factor_once.cpp
#include "geometry/solve/factor_once.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/solve/sparse_lu.h"

namespace dgm::bake {
namespace {
using SparseMatrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;

constexpr double kSymmetryTolerance = 1e-12;  // cotangents of one edge summed in the two orders differ by less
constexpr double kRefineAbove = 1e-14;        // normwise backward error
constexpr double kAcceptBelow = 1e-9;
constexpr int kMaxRefinements = 3;

bool same_matrix(const SparseMatrix& a, const SparseMatrix& b) {
    return a.rows() == b.rows() && a.cols() == b.cols() && a.nonZeros() == b.nonZeros() &&
           std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.outerSize() + 1, b.outerIndexPtr()) &&
           std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), b.innerIndexPtr()) &&
           std::equal(a.valuePtr(), a.valuePtr() + a.nonZeros(), b.valuePtr());
}

double infinity_norm(const SparseMatrix& a) {
    Vector sums = Vector::Zero(a.rows());
    for (int k = 0; k < a.outerSize(); ++k)
        for (SparseMatrix::InnerIterator it(a, k); it; ++it) sums[it.row()] += std::abs(it.value());
    return sums.size() > 0 ? sums.maxCoeff() : 0;
}

bool is_symmetric(const SparseMatrix& a) {
    const SparseMatrix transposed = a.transpose();
    if (!std::equal(a.outerIndexPtr(), a.outerIndexPtr() + a.outerSize() + 1, transposed.outerIndexPtr()) ||
        !std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), transposed.innerIndexPtr()))
        return false;
    const Vector diagonal = a.diagonal().cwiseAbs();
    for (int k = 0; k < a.outerSize(); ++k) {
        SparseMatrix::InnerIterator other(transposed, k);
        for (SparseMatrix::InnerIterator it(a, k); it; ++it, ++other)
            if (!(std::abs(it.value() - other.value()) <=
                  kSymmetryTolerance * std::min(diagonal[it.row()], diagonal[it.col()])))
                return false;
    }
    return true;
}
}  // namespace

struct FactorOnce::State {
    enum class Kind { kNone, kSymmetric, kGeneral };

    SparseMatrix matrix;          // as the caller last passed it
    std::vector<int> free_of;     // row -> unknown, -1 where pinned
    std::vector<int> row_of;      // unknown -> row
    SparseMatrix free, coupling;  // A_FF, and A_FP over all columns
    double norm = 0;
    Kind kind = Kind::kNone;
    Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> symmetric;
    SparseLu general;
    SolveStatistics statistics;

    void eliminate_pinned() {
        const int n = static_cast<int>(matrix.rows());
        std::vector<std::uint8_t> pinned(static_cast<std::size_t>(n), 1), has_one(static_cast<std::size_t>(n), 0);
        for (int k = 0; k < matrix.outerSize(); ++k)
            for (SparseMatrix::InnerIterator it(matrix, k); it; ++it) {
                if (it.value() == 0) continue;
                if (it.row() == it.col() && it.value() == 1) {
                    has_one[static_cast<std::size_t>(it.row())] = 1;
                } else {
                    pinned[static_cast<std::size_t>(it.row())] = 0;
                }
            }
        free_of.assign(static_cast<std::size_t>(n), -1);
        row_of.clear();
        for (int row = 0; row < n; ++row)
            if (const auto r = static_cast<std::size_t>(row); pinned[r] == 0 || has_one[r] == 0) {
                free_of[r] = static_cast<int>(row_of.size());
                row_of.push_back(row);
            }
        std::vector<Eigen::Triplet<double>> inside, across;
        inside.reserve(static_cast<std::size_t>(matrix.nonZeros()));
        for (int k = 0; k < matrix.outerSize(); ++k)
            for (SparseMatrix::InnerIterator it(matrix, k); it; ++it) {
                const int i = free_of[static_cast<std::size_t>(it.row())];
                const int j = free_of[static_cast<std::size_t>(it.col())];
                if (i < 0) continue;
                if (j < 0) {
                    across.emplace_back(i, static_cast<int>(it.col()), it.value());
                } else {
                    inside.emplace_back(i, j, it.value());
                }
            }
        const int unknowns = static_cast<int>(row_of.size());
        free.resize(unknowns, unknowns);
        free.setFromTriplets(inside.begin(), inside.end());
        coupling.resize(unknowns, n);
        coupling.setFromTriplets(across.begin(), across.end());
        norm = infinity_norm(free);
    }

    bool factorize_general() {
        kind = Kind::kNone;
        ++statistics.factorizations;
        ++statistics.unsymmetric;
        if (!general.factorize(free)) return false;
        kind = Kind::kGeneral;
        return true;
    }

    void factorize() {
        kind = Kind::kNone;
        if (row_of.empty()) return;
        if (is_symmetric(free)) {
            ++statistics.factorizations;
            symmetric.compute(free);
            if (symmetric.info() == Eigen::Success) {
                kind = Kind::kSymmetric;
                return;
            }
        }
        factorize_general();
    }

    [[nodiscard]] Vector apply_inverse(const Vector& r) const {
        if (kind == Kind::kSymmetric) return symmetric.solve(r);
        return general.solve(r);
    }

    /// Solve and refine; false if the backward error stays above kAcceptBelow.
    [[nodiscard]] bool solve_free(const Vector& r, Vector& y) const {
        if (kind == Kind::kNone) return false;
        y = apply_inverse(r);
        double best = std::numeric_limits<double>::infinity();
        Vector kept;
        for (int k = 0; k <= kMaxRefinements; ++k) {
            if (!y.allFinite()) break;
            const Vector residual = r - free * y;
            const double scale = norm * y.cwiseAbs().maxCoeff() + r.cwiseAbs().maxCoeff();
            const double error = scale > 0 ? residual.cwiseAbs().maxCoeff() / scale : 0;
            if (!(error < 0.5 * best)) break;  // no progress: keep the better of the two
            best = error;
            kept = y;
            if (best <= kRefineAbove) break;
            y += apply_inverse(residual);
        }
        y = kept;
        return best <= kAcceptBelow;
    }
};

FactorOnce::FactorOnce() : state_(std::make_unique<State>()) {}
FactorOnce::~FactorOnce() = default;

const SolveStatistics& FactorOnce::statistics() const {
    return state_->statistics;
}

bool FactorOnce::solve(const SparseMatrix& A, const Vector& b, Vector& x) {
    State& s = *state_;
    if (A.rows() != A.cols() || A.rows() != b.size() || !A.isCompressed() || !b.allFinite()) return false;
    for (Eigen::Index k = 0; k < A.nonZeros(); ++k)
        if (!std::isfinite(A.valuePtr()[k])) return false;
    if (!same_matrix(A, s.matrix)) {
        s.matrix = A;
        s.eliminate_pinned();
        s.factorize();
    }
    ++s.statistics.solves;
    x = b;  // right for pinned rows
    if (s.row_of.empty()) return true;
    Vector r(static_cast<Eigen::Index>(s.row_of.size())), y;
    for (Eigen::Index k = 0; k < r.size(); ++k) r[k] = b[s.row_of[static_cast<std::size_t>(k)]];
    r -= s.coupling * b;
    if (!s.solve_free(r, y)) {
        if (s.kind != State::Kind::kSymmetric || !s.factorize_general() || !s.solve_free(r, y)) return false;
    }
    for (Eigen::Index k = 0; k < y.size(); ++k) x[s.row_of[static_cast<std::size_t>(k)]] = y[k];
    return true;
}

}  // namespace dgm::bake
