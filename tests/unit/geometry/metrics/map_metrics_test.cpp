// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/metrics/map_metrics_test.cpp
// Distortion worked out by hand for linear maps, and orient2d against rational arithmetic.
#include "geometry/metrics/map_metrics.h"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "test_meshes.h"

namespace dgm::bake {
namespace {
using boost::multiprecision::cpp_rational;
using model::Vec2d;
using model::Vec3d;

/// Unit square in the plane, mapped by (x, y) -> (a x + b y, c x + d y) + shift.
MapMetrics linear_map(double a, double b, double c, double d, Vec2d shift = {}) {
    const model::TriMesh mesh = test::square(1, 0, 5);
    std::vector<Vec2d> uv;
    for (const Vec3d& p : mesh.positions) uv.push_back(Vec2d{a * p.x + b * p.y, c * p.x + d * p.y} + shift);
    return measure_map(mesh.positions, mesh.faces, uv);
}

TEST(MapMetrics, IdentityAndDoublingAreIsometricUpToScale) {
    for (const double scale : {1.0, 2.0, 1e-6}) {
        const MapMetrics m = linear_map(scale, 0, 0, scale);
        EXPECT_NEAR(m.stretch_l2, 1, 1e-12);
        EXPECT_NEAR(m.stretch_linf, 1, 1e-12);
        EXPECT_NEAR(m.symmetric_dirichlet, 1, 1e-12);
        EXPECT_NEAR(m.angle, 1, 1e-12);
        EXPECT_NEAR(m.area, 1, 1e-12);
        EXPECT_EQ(m.flips + m.degenerate + m.not_finite, 0u);
    }
}

/// The map stretches x by 4: from map to surface the singular values are 1 and 1/4.
TEST(MapMetrics, AnisotropicStretchByHand) {
    const MapMetrics m = linear_map(4, 0, 0, 1);
    EXPECT_NEAR(m.stretch_l2, std::sqrt((1 + 1.0 / 16) / 2) * 2, 1e-12);  // sqrt(sum A / sum A') = 2
    EXPECT_NEAR(m.stretch_linf, 2, 1e-12);
    // s = 1, 1/4: mean of s^2 is 17/16, of s^-2 is 17; the best scale gives sqrt(17/16 * 17) / 2.
    EXPECT_NEAR(m.symmetric_dirichlet, 17.0 / 8, 1e-12);
    EXPECT_NEAR(m.angle, (4 + 0.25) / 2, 1e-12);
    EXPECT_NEAR(m.area, 1, 1e-12);
}

/// Shear by 1: J = [1 1; 0 1], its inverse has J^-T J^-1 of trace 3 and determinant 1, so the larger singular value is
/// the golden ratio.
TEST(MapMetrics, ShearByHand) {
    const double golden = (1 + std::sqrt(5.0)) / 2;
    const MapMetrics m = linear_map(1, 1, 0, 1, {1e3, -1e3});
    EXPECT_NEAR(m.stretch_l2, std::sqrt(1.5), 1e-9);
    EXPECT_NEAR(m.stretch_linf, golden, 1e-9);
    EXPECT_NEAR(m.symmetric_dirichlet, 1.5, 1e-9);
    EXPECT_NEAR(m.angle, (golden * golden + 1 / (golden * golden)) / 2, 1e-9);
    EXPECT_NEAR(m.area, 1, 1e-9);
}

/// Two triangles of equal area on the surface, mapped with areas 1/2 and 2: r = 1, 4.
TEST(MapMetrics, UnevenAreasByHand) {
    const std::vector<Vec3d> q{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}, {6, 5, 5}, {5, 6, 5}};
    const std::vector<Vec2d> p{{0, 0}, {1, 0}, {0, 1}, {3, 3}, {5, 3}, {3, 5}};
    const std::vector<model::Face> faces{{0, 1, 2}, {3, 4, 5}};
    const MapMetrics m = measure_map(q, faces, p);
    EXPECT_NEAR(m.area, std::sqrt(2.5 * 0.625), 1e-12);
    EXPECT_NEAR(m.stretch_l2, std::sqrt((1 + 0.25) / 2) * std::sqrt(2.5), 1e-12);
    EXPECT_NEAR(m.stretch_linf, std::sqrt(2.5), 1e-12);
    EXPECT_NEAR(m.symmetric_dirichlet, 0.5 * std::sqrt((2 + 0.5) / 2 * (2 + 8) / 2), 1e-12);
    EXPECT_NEAR(m.angle, 1, 1e-12);
}

TEST(MapMetrics, FlipsDegenerateAndNotFiniteAreCountedAndLeftOut) {
    const std::vector<Vec3d> q{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}};
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<Vec2d> p{{0, 0}, {1, 0}, {0, 1}, {nan, 0}};
    const std::vector<model::Face> faces{{0, 1, 2}, {0, 2, 1}, {0, 1, 1}, {1, 3, 2}};
    const MapMetrics m = measure_map(q, faces, p);
    EXPECT_EQ(m.flips, 1u);
    EXPECT_EQ(m.degenerate, 1u);
    EXPECT_EQ(m.not_finite, 1u);
    EXPECT_NEAR(m.stretch_l2, 1, 1e-15);
}

int exact_sign(Vec2d a, Vec2d b, Vec2d c) {
    const cpp_rational ax(a.x), ay(a.y), bx(b.x), by(b.y), cx(c.x), cy(c.y);
    const cpp_rational det = (ax - cx) * (by - cy) - (ay - cy) * (bx - cx);
    return det > 0 ? 1 : det < 0 ? -1 : 0;
}

TEST(Orient2d, AgreesWithRationalsOnNearlyCollinearPoints) {
    std::mt19937_64 random(17);
    std::uniform_real_distribution<double> uniform(-1, 1);
    int counts[3] = {0, 0, 0}, naive_wrong = 0;
    for (int k = 0; k < 20'000; ++k) {
        const double size = std::ldexp(1, static_cast<int>(random() % 80) - 40);
        const Vec2d a{uniform(random) * size, uniform(random) * size},
            b{uniform(random) * size, uniform(random) * size};
        const double t = 3 * uniform(random);
        Vec2d c{a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)};
        for (int step = static_cast<int>(random() % 3); step > 0; --step) c.x = std::nextafter(c.x, 1e300);
        if (k % 4 == 0) c = {2 * b.x - a.x, 2 * b.y - a.y};  // often exactly collinear
        const int want = exact_sign(a, b, c);
        ASSERT_EQ(orient2d(a, b, c), want) << "case " << k;
        ASSERT_EQ(orient2d(b, a, c), -want);
        ++counts[want + 1];
        const double naive = (a.x - c.x) * (b.y - c.y) - (a.y - c.y) * (b.x - c.x);
        naive_wrong += (naive > 0) - (naive < 0) != want;
    }
    EXPECT_GT(counts[0], 1000);
    EXPECT_GT(counts[1], 1000);
    EXPECT_GT(counts[2], 1000);
    EXPECT_GT(naive_wrong, 1000) << "the cases are too easy to test the exact path";
}

TEST(Orient2d, GridAroundALine) {
    for (int i = 0; i < 64; ++i)
        for (int j = 0; j < 64; ++j) {
            const Vec2d a{0.5 + i * 0x1p-53, 0.5 + j * 0x1p-53}, b{12, 12}, c{24, 24};
            ASSERT_EQ(orient2d(a, b, c), exact_sign(a, b, c));
        }
}

}  // namespace
}  // namespace dgm::bake
