// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/solve/sparse_lu_test.cpp
#include "geometry/solve/sparse_lu.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>
#include <random>
#include <vector>

namespace dgm::bake {
namespace {
using Matrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;
using Entries = std::vector<Eigen::Triplet<double>>;

Matrix sparse(int n, const Entries& entries) {
    Matrix out(n, n);
    out.setFromTriplets(entries.begin(), entries.end());
    return out;
}

/// A grid of side * side unknowns with unsymmetric positive weights: each row is weakly dominant, as with mean values.
Matrix weighted_grid(int side, std::mt19937& draw) {
    std::uniform_real_distribution<double> weight(0.01, 5);
    Entries entries;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j) {
            double sum = i == 0 || j == 0 || i == side - 1 || j == side - 1 ? weight(draw) : 0;
            for (const auto& [di, dj] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {1, 1}, {-1, -1}}) {
                const int a = i + di, b = j + dj;
                if (a < 0 || b < 0 || a >= side || b >= side) continue;
                const double w = weight(draw);
                entries.emplace_back(i * side + j, a * side + b, -w);
                sum += w;
            }
            entries.emplace_back(i * side + j, i * side + j, sum);
        }
    return sparse(side * side, entries);
}

double backward_error(const Matrix& A, const Vector& x, const Vector& b) {
    const Vector most = A.cwiseAbs() * x.cwiseAbs() + b.cwiseAbs();
    return ((A * x - b).cwiseAbs().array() / most.array().max(1e-300)).maxCoeff();
}

TEST(SparseLu, KnownSystem) {
    SparseLu lu;  // 2 * 1 + 1 * 2 = 4, 3 * 1 + 4 * 2 = 11
    ASSERT_TRUE(lu.factorize(sparse(2, {{0, 0, 2.0}, {0, 1, 1.0}, {1, 0, 3.0}, {1, 1, 4.0}})));
    const Vector x = lu.solve(Vector{{4.0, 11.0}});
    EXPECT_NEAR(x[0], 1, 1e-15);
    EXPECT_NEAR(x[1], 2, 1e-15);
}

TEST(SparseLu, PermutationsNeedOtherPivotsThanTheDiagonal) {
    Entries entries;
    for (int k = 0; k < 50; ++k)
        entries.emplace_back((k * 7 + 3) % 50, k, k + 1.0);  // nothing on the diagonal but chance
    SparseLu lu;
    ASSERT_TRUE(lu.factorize(sparse(50, entries)));
    Vector b(50);
    for (int k = 0; k < 50; ++k) b[(k * 7 + 3) % 50] = (k + 1.0) * (k - 20);
    const Vector x = lu.solve(b);
    for (int k = 0; k < 50; ++k) EXPECT_EQ(x[k], k - 20);
}

TEST(SparseLu, SmallDiagonalsAreNotTaken) {
    // With the pivot 1e-20 the second unknown would come out as 0 (Golub, Van Loan, 3.4.1).
    SparseLu lu;
    ASSERT_TRUE(lu.factorize(sparse(2, {{0, 0, 1e-20}, {0, 1, 1.0}, {1, 0, 1.0}, {1, 1, 1.0}})));
    const Vector x = lu.solve(Vector{{1.0, 2.0}});
    EXPECT_NEAR(x[0], 1, 1e-15);
    EXPECT_NEAR(x[1], 1, 1e-15);
}

TEST(SparseLu, SolvesRandomMatricesAsADenseFactorizationDoes) {
    std::mt19937 draw(7);
    for (int n = 1; n <= 60; ++n) {
        Entries entries;
        for (int k = 0; k < n; ++k) entries.emplace_back(k, (k + 1) % n, 1.0 + static_cast<double>(draw() % 8));
        for (int k = 0; k < 3 * n; ++k)
            entries.emplace_back(static_cast<int>(draw() % static_cast<unsigned>(n)),
                                 static_cast<int>(draw() % static_cast<unsigned>(n)), draw() * 0x1p-31 - 1);
        const Matrix A = sparse(n, entries);
        const Vector b = Vector::LinSpaced(n, -1, 2);
        SparseLu lu;
        ASSERT_TRUE(lu.factorize(A)) << n;
        const Vector x = lu.solve(b), expected = Eigen::FullPivLU<Eigen::MatrixXd>(Eigen::MatrixXd(A)).solve(b);
        EXPECT_LT((x - expected).cwiseAbs().maxCoeff(), 1e-8 * (1 + expected.cwiseAbs().maxCoeff())) << n;
    }
}

TEST(SparseLu, LargeGridsToRounding) {
    std::mt19937 draw(3);
    const Matrix A = weighted_grid(120, draw);
    Vector b(A.rows());
    for (double& value : b) value = draw() * 0x1p-31 - 1;
    SparseLu lu;
    ASSERT_TRUE(lu.factorize(A));
    EXPECT_LT(backward_error(A, lu.solve(b), b), 1e-13);
}

TEST(SparseLu, RefusesSingularAndNonFiniteMatrices) {
    SparseLu lu;
    EXPECT_FALSE(lu.factorize(sparse(2, {{0, 0, 1.0}, {0, 1, -1.0}, {1, 0, -1.0}, {1, 1, 1.0}})));
    EXPECT_FALSE(lu.factorize(sparse(2, {{0, 0, 1.0}, {1, 0, 1.0}})));  // an empty column
    const double huge = std::numeric_limits<double>::max();
    EXPECT_FALSE(lu.factorize(sparse(2, {{0, 0, 1.0}, {0, 1, huge}, {1, 0, 1.0}, {1, 1, -huge}})));  // overflows
    ASSERT_TRUE(lu.factorize(sparse(1, {{0, 0, 4.0}})));  // and is as good as new afterwards
    EXPECT_EQ(lu.solve(Vector{{2.0}})[0], 0.5);
}
}  // namespace
}  // namespace dgm::bake
