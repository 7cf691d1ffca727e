// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/mesh/polygon_test.cpp
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "mesh/polygon.h"

namespace {

using dgm::formats::CornerTriple;
using dgm::formats::PolygonBudget;
using dgm::model::Vec3d;

bool triangulate_polygon(const std::vector<Vec3d>& corners, std::vector<CornerTriple>& out) {
    PolygonBudget budget;
    return dgm::formats::triangulate_polygon(corners, out, budget);
}

double signed_area(const std::vector<Vec3d>& p, const std::vector<std::uint32_t>& loop) {
    double sum = 0;
    for (std::size_t k = 0; k < loop.size(); ++k) {
        const Vec3d &a = p[loop[k]], &b = p[loop[(k + 1) % loop.size()]];
        sum += a.x * b.y - a.y * b.x;
    }
    return sum / 2;
}

/// In the plane z = 0: all triangles wind like the polygon and their areas add up, so none lies outside.
/// @param rounding  of the area of a triangle whose corners are in line but for their own rounding
void expect_tiling(const std::vector<Vec3d>& p, double rounding = 0) {
    std::vector<CornerTriple> triangles;
    EXPECT_TRUE(triangulate_polygon(p, triangles));
    ASSERT_EQ(triangles.size(), p.size() - 2);
    std::vector<std::uint32_t> all(p.size());
    for (std::uint32_t k = 0; k < all.size(); ++k) all[k] = k;
    double sum = 0;
    std::set<std::uint32_t> used;
    for (const CornerTriple& t : triangles) {
        const double area = signed_area(p, {t[0], t[1], t[2]});
        EXPECT_GE(area, -rounding);
        sum += area;
        used.insert(t.begin(), t.end());
    }
    EXPECT_EQ(used.size(), p.size());
    EXPECT_NEAR(sum, signed_area(p, all), 1e-12 * std::abs(sum));
}

TEST(Polygon, ConvexQuadsSplitAlongTheFirstDiagonal) {
    std::vector<CornerTriple> out;
    EXPECT_TRUE(triangulate_polygon(std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, out));
    EXPECT_EQ(out, (std::vector<CornerTriple>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(Polygon, ConcaveQuadsSplitFromTheirNotch) {
    // The notch is corner 1: the diagonal 0-2 would run outside.
    expect_tiling({{0, 0, 0}, {1, 0.1, 0}, {2, 0, 0}, {1, 3, 0}});
    expect_tiling({{2, 0, 0}, {1, 3, 0}, {0, 0, 0}, {1, 0.1, 0}});
}

TEST(Polygon, StarsAndCombsAreTiled) {
    std::vector<Vec3d> star;
    for (int k = 0; k < 202; ++k) {
        const double angle = 2 * 3.14159265358979 * k / 202, radius = k % 2 == 0 ? 1 : 0.1;
        star.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
    }
    expect_tiling(star);
    std::vector<Vec3d> comb;
    for (int k = 0; k < 50; ++k) {
        comb.push_back({2.0 * k, 0, 0});
        comb.push_back({2.0 * k + 1, 0, 0});
        comb.push_back({2.0 * k + 1, 10, 0});
        comb.push_back({2.0 * k + 2, 10, 0});
    }
    comb.push_back({100, 20, 0});
    comb.push_back({0, 20, 0});
    expect_tiling(comb);
}

TEST(Polygon, LargeDiscsAreQuick) {
    std::vector<Vec3d> disc;
    for (int k = 0; k < 10'000; ++k)
        disc.push_back({std::cos(k * 6.28318530717958 / 10'000), std::sin(k * 6.28318530717958 / 10'000), 0});
    expect_tiling(disc);
}

std::vector<Vec3d> teeth(int count, double turn) {
    std::vector<Vec3d> out{{0, -1, 0}, {2.0 * count, 0, 0}};
    for (int k = count; k-- > 0;) {
        out.push_back({2.0 * k + 1, 100, 0});
        out.push_back({2.0 * k, 1, 0});
    }
    for (Vec3d& p : out)
        p = {std::cos(turn) * p.x - std::sin(turn) * p.y, std::sin(turn) * p.x + std::cos(turn) * p.y, 0};
    return out;
}

TEST(Polygon, LargeCombsAreQuick) {
    // One test a pair of corners would be 10^10 of them.
    expect_tiling(teeth(4'000, 0));
    expect_tiling(teeth(50'000, 0));
    expect_tiling(teeth(50'000, 0.3), 1e-16 * 2e5 * 2e5);
}

TEST(Polygon, OneBudgetServesAllPolygonsOfAFile) {
    // All corners in a bundle and a few far away.
    std::vector<Vec3d> bundle{{-1000, 0, 0}};
    for (int k = 0; k < 20'000; ++k) bundle.push_back({1e-6 * k, k % 2 * 1e-7, 0});
    bundle.push_back({0, 1000, 0});
    PolygonBudget budget;
    std::vector<CornerTriple> out;
    int whole = 0;
    for (int k = 0; k < 30; ++k) {
        out.clear();
        whole += dgm::formats::triangulate_polygon(bundle, out, budget) ? 1 : 0;
        EXPECT_EQ(out.size(), bundle.size() - 2);
    }
    EXPECT_EQ(whole, 30) << "corners that crowd are no reason for a fan";
    EXPECT_LT(budget.left(), (std::uint64_t{1} << 25) + std::uint64_t{512} * 30 * bundle.size());
    // What comes next is not made to pay.
    const std::vector<Vec3d> dart{{0, 0, 0}, {1, 0.1, 0}, {2, 0, 0}, {1, 3, 0}};
    out.clear();
    EXPECT_TRUE(dgm::formats::triangulate_polygon(dart, out, budget));
}

/// A star of n corners whose every edge crosses nearly all others.
std::vector<Vec3d> crossed(int n) {
    std::vector<Vec3d> out;
    for (int k = 0; k < n; ++k) {
        const double angle = 6.28318530717958 * k * (n / 2) / n;
        out.push_back({std::cos(angle), std::sin(angle), 0});
    }
    return out;
}

TEST(Polygon, FansOfCrossedCornersHaveABoundAFile) {
    std::vector<CornerTriple> out;
    PolygonBudget several;
    int count = 0;
    while (!several.is_crossed() && count < 100) {
        EXPECT_FALSE(dgm::formats::triangulate_polygon(crossed(999), out, several));
        ++count;
    }
    EXPECT_GE(count, 2) << "one polygon of 999 corners";
    EXPECT_LE(count, 8) << "some of its ears can be cut off first";
    PolygonBudget large;
    EXPECT_FALSE(dgm::formats::triangulate_polygon(crossed(9999), out, large));
    EXPECT_TRUE(large.is_crossed());
}

TEST(Polygon, BowTiesPointsAndLinesAreNotCrossed) {
    PolygonBudget budget;
    std::vector<CornerTriple> out;
    for (int k = 0; k < 20'000; ++k) {
        out.clear();
        EXPECT_FALSE(dgm::formats::triangulate_polygon(crossed(15), out, budget));
    }
    std::vector<Vec3d> line, broken = crossed(9999);
    for (int k = 0; k < 9'000; ++k) line.push_back({1.0 * (k * 7 % 9'000), 2.0 * (k * 7 % 9'000), 0});
    broken[5].x = std::numeric_limits<double>::quiet_NaN();
    for (const std::vector<Vec3d>& p : {line, broken, std::vector<Vec3d>(9'000)})
        EXPECT_FALSE(dgm::formats::triangulate_polygon(p, out, budget));
    EXPECT_TRUE(dgm::formats::triangulate_polygon(teeth(20'000, 0), out, budget));
    EXPECT_FALSE(budget.is_crossed());
}

TEST(Polygon, ScaleAndOffsetDoNotMatter) {
    const std::vector<Vec3d> dart{{0, 0, 0}, {1, 0.1, 0}, {2, 0, 0}, {1, 3, 0}};
    std::vector<CornerTriple> expected;
    (void)triangulate_polygon(dart, expected);
    for (const double scale : {1e-200, 1e200, 1e307}) {
        std::vector<Vec3d> scaled;
        for (const Vec3d& p : dart) scaled.push_back(p * scale);
        std::vector<CornerTriple> out;
        EXPECT_TRUE(triangulate_polygon(scaled, out));
        EXPECT_EQ(out, expected);
    }
}

TEST(Polygon, FlatCrossedAndInfiniteOnesBecomeFans) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    for (const std::vector<Vec3d>& p : {std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}},
                                        {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}},
                                        {{0, 0, 0}, {1, 0, 0}, {kInfinity, 1, 0}, {0, 1, 0}}}) {
        std::vector<CornerTriple> out;
        EXPECT_FALSE(triangulate_polygon(p, out));
        EXPECT_EQ(out.size(), p.size() - 2);
    }
}

}  // namespace
