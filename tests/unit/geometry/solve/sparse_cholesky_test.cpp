// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/solve/sparse_cholesky_test.cpp
#include "geometry/solve/sparse_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace dgm::bake {
namespace {
using SparseMatrix = Eigen::SparseMatrix<double>;

/// Lower triangle of a definite matrix: a grid graph of side x side nodes, each a block, with random couplings, and
/// `far` random long edges so that the fronts become uneven.
SparseMatrix grid_matrix(int side, int block, int far, unsigned seed) {
    std::mt19937 random(seed);
    const auto value = [&] { return static_cast<double>(random() % 2001) / 1000 - 1; };
    const int nodes = side * side;
    Eigen::VectorXd sums = Eigen::VectorXd::Constant(nodes * block, 0.25);
    std::vector<Eigen::Triplet<double>> entries;
    const auto couple = [&](int a, int b) {
        for (int p = 0; p < block; ++p)
            for (int q = 0; q < block; ++q) {
                const int row = std::max(a, b) * block + p, col = std::min(a, b) * block + q;
                if (row <= col) continue;
                const double v = value();
                entries.emplace_back(row, col, v);
                sums[row] += std::abs(v);
                sums[col] += std::abs(v);
            }
    };
    for (int v = 0; v < nodes; ++v) {
        couple(v, v);
        if (v % side + 1 < side) couple(v, v + 1);
        if (v + side < nodes) couple(v, v + side);
    }
    for (int k = 0; k < far; ++k) couple(static_cast<int>(random() % nodes), static_cast<int>(random() % nodes));
    for (int k = 0; k < nodes * block; ++k) entries.emplace_back(k, k, sums[k]);  // diagonally dominant
    SparseMatrix m(nodes * block, nodes * block);
    m.setFromTriplets(entries.begin(), entries.end());
    return m;
}

class SparseCholeskySolves : public ::testing::TestWithParam<std::tuple<int, int, Ordering>> {};
INSTANTIATE_TEST_SUITE_P(All, SparseCholeskySolves,
                         ::testing::Combine(::testing::Values(1, 2, 7, 40), ::testing::Values(1, 2, 3),
                                            ::testing::Values(Ordering::kMinimumDegree, Ordering::kNestedDissection)));

TEST_P(SparseCholeskySolves, WhatWasMultiplied) {
    const auto [side, block, ordering] = GetParam();
    const SparseMatrix first = grid_matrix(side, block, side, 1);
    SparseMatrix second = first;  // same pattern, other values
    for (int k = 0; k < second.outerSize(); ++k)
        for (SparseMatrix::InnerIterator it(second, k); it; ++it) it.valueRef() *= it.row() == it.col() ? 1.5 : -0.5;
    SparseCholesky solver;
    solver.analyze(first, ordering, block);
    for (const SparseMatrix& m : {first, second}) {
        ASSERT_TRUE(solver.factorize(m));
        ASSERT_EQ(solver.rows(), static_cast<std::size_t>(m.rows()));
        const Eigen::MatrixXd truth = Eigen::MatrixXd::Random(m.rows(), 3);
        Eigen::MatrixXd x = m.selfadjointView<Eigen::Lower>() * truth;
        solver.solve({x.data(), static_cast<std::size_t>(x.size())});
        EXPECT_LT((x - truth).cwiseAbs().maxCoeff(), 1e-11);
    }
}

TEST(SparseCholesky, DenseFrontsGoThroughEveryKernel) {
    // One front of 300 unknowns: panels, the remainder of a panel, and the blocked product.
    const int n = 300;
    Eigen::MatrixXd dense = Eigen::MatrixXd::Random(n, n);
    dense = (dense * dense.transpose()).eval();
    dense.diagonal().array() += 1;
    const Eigen::MatrixXd lower_part = dense.triangularView<Eigen::Lower>();
    SparseMatrix lower = lower_part.sparseView();
    lower.makeCompressed();
    SparseCholesky solver;
    solver.analyze(lower, Ordering::kMinimumDegree);
    ASSERT_TRUE(solver.factorize(lower));
    const Eigen::VectorXd truth = Eigen::VectorXd::LinSpaced(n, -1, 2);
    Eigen::VectorXd x = dense * truth;
    solver.solve({x.data(), static_cast<std::size_t>(n)});
    EXPECT_LT((x - truth).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(SparseCholesky, ColumnsAreSolvedAlikeAloneOrTogether) {
    const SparseMatrix m = grid_matrix(30, 2, 10, 3);
    SparseCholesky solver;
    solver.analyze(m, Ordering::kNestedDissection, 2);
    ASSERT_TRUE(solver.factorize(m));
    Eigen::MatrixXd together = Eigen::MatrixXd::Random(m.rows(), 2), alone = together;
    solver.solve({together.data(), static_cast<std::size_t>(together.size())});
    for (int c = 0; c < 2; ++c) solver.solve({alone.col(c).data(), static_cast<std::size_t>(m.rows())});
    EXPECT_EQ(std::memcmp(together.data(), alone.data(), static_cast<std::size_t>(alone.size()) * sizeof(double)), 0);
}

TEST(SparseCholesky, SeparatePartsAndAnEmptyMatrix) {
    SparseMatrix diagonal(5, 5);
    for (int k = 0; k < 5; ++k) diagonal.insert(k, k) = k + 1;
    diagonal.makeCompressed();
    SparseCholesky solver;
    solver.analyze(diagonal, Ordering::kNestedDissection);
    ASSERT_TRUE(solver.factorize(diagonal));
    std::vector<double> x{1, 4, 9, 16, 25};
    solver.solve(x);
    for (int k = 0; k < 5; ++k) EXPECT_DOUBLE_EQ(x[static_cast<std::size_t>(k)], k + 1);
    const SparseMatrix none(0, 0);
    solver.analyze(none, Ordering::kMinimumDegree);
    EXPECT_TRUE(solver.factorize(none));
    EXPECT_EQ(solver.rows(), 0U);
    solver.solve({});
}

TEST(SparseCholesky, RefusesWhatIsNotDefinite) {
    SparseMatrix m = grid_matrix(9, 1, 0, 5);
    SparseCholesky solver;
    solver.analyze(m, Ordering::kMinimumDegree);
    ASSERT_TRUE(solver.factorize(m));
    m.coeffRef(40, 40) = -1;
    EXPECT_FALSE(solver.factorize(m));
    m.coeffRef(40, 40) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(solver.factorize(m));
    m.coeffRef(40, 40) = 9;
    EXPECT_TRUE(solver.factorize(m));
}
}  // namespace
}  // namespace dgm::bake
