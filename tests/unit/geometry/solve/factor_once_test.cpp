// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/solve/factor_once_test.cpp
#include "geometry/solve/factor_once.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace dgm::bake {
namespace {
using Matrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;

Matrix sparse(int n, const std::vector<Eigen::Triplet<double>>& entries) {
    Matrix out(n, n);
    out.setFromTriplets(entries.begin(), entries.end());
    return out;
}

/// A chain pinned at its first row, as CGAL assembles it: the pinned row is the identity's, its column is not.
Matrix chain(double stiffness) {
    return sparse(3, {{0, 0, 1.0},
                      {1, 0, -1.0},
                      {1, 1, 1.0 + stiffness},
                      {1, 2, -stiffness},
                      {2, 1, -stiffness},
                      {2, 2, stiffness}});
}

TEST(FactorOnce, FactorizesOneMatrixOnce) {
    FactorOnce solver;
    Vector x;
    for (int k = 1; k <= 5; ++k) {
        const Matrix again = chain(2);  // another object with the same entries
        // x0 = k; row 1: -x0 + 3 x1 - 2 x2 = 0; row 2: -2 x1 + 2 x2 = 2k  =>  x1 = 3k, x2 = 4k.
        ASSERT_TRUE(solver.solve(again, Vector{{1.0 * k, 0.0, 2.0 * k}}, x));
        EXPECT_DOUBLE_EQ(x[0], k);
        EXPECT_NEAR(x[1], 3 * k, 1e-13);
        EXPECT_NEAR(x[2], 4 * k, 1e-13);
    }
    EXPECT_EQ(solver.statistics().factorizations, 1U);
    EXPECT_EQ(solver.statistics().solves, 5U);
    EXPECT_EQ(solver.statistics().unsymmetric, 0U);
}

TEST(FactorOnce, NoticesAChangedEntry) {
    FactorOnce solver;
    Vector x;
    ASSERT_TRUE(solver.solve(chain(2), Vector{{1.0, 0.0, 2.0}}, x));
    // With stiffness 4: 4 (x2 - x1) = 2, x1 - x0 = 2  =>  x1 = 3, x2 = 3.5.
    ASSERT_TRUE(solver.solve(chain(4), Vector{{1.0, 0.0, 2.0}}, x));
    EXPECT_NEAR(x[1], 3, 1e-13);
    EXPECT_NEAR(x[2], 3.5, 1e-13);
    EXPECT_EQ(solver.statistics().factorizations, 2U);
}

TEST(FactorOnce, FallsBackToLuForUnsymmetricAndIndefiniteMatrices) {
    FactorOnce solver;
    Vector x;
    ASSERT_TRUE(solver.solve(sparse(2, {{0, 0, 2.0}, {0, 1, 1.0}, {1, 0, 3.0}, {1, 1, 4.0}}), Vector{{4.0, 11.0}}, x));
    EXPECT_NEAR(x[0], 1, 1e-14);  // 2 + 2 = 4, 3 + 8 = 11
    EXPECT_NEAR(x[1], 2, 1e-14);
    EXPECT_EQ(solver.statistics().unsymmetric, 1U);

    // Symmetric with a zero pivot: LDL^T without pivoting breaks down, the answer is still (5, 7).
    ASSERT_TRUE(solver.solve(sparse(2, {{0, 0, 0.0}, {0, 1, 1.0}, {1, 0, 1.0}, {1, 1, 0.0}}), Vector{{7.0, 5.0}}, x));
    EXPECT_NEAR(x[0], 5, 1e-14);
    EXPECT_NEAR(x[1], 7, 1e-14);
    EXPECT_EQ(solver.statistics().unsymmetric, 2U);
}

TEST(FactorOnce, RefusesSingularAndNonFiniteSystems) {
    FactorOnce solver;
    Vector x;
    EXPECT_FALSE(
        solver.solve(sparse(2, {{0, 0, 1.0}, {0, 1, -1.0}, {1, 0, -1.0}, {1, 1, 1.0}}), Vector{{1.0, 1.0}}, x));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(solver.solve(sparse(1, {{0, 0, nan}}), Vector{{1.0}}, x));
    EXPECT_FALSE(solver.solve(sparse(1, {{0, 0, 2.0}}), Vector{{nan}}, x));
    EXPECT_FALSE(solver.solve(sparse(1, {{0, 0, 2.0}}), Vector{{1.0, 2.0}}, x));
}
}  // namespace
}  // namespace dgm::bake
