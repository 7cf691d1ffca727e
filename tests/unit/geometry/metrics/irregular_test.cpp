// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/metrics/irregular_test.cpp
// What grids are held against: the least error of triangles by closed forms, and irregular meshes that are fitted
// again.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "geometry/metrics/map_metrics.h"
#include "geometry/metrics/surface_error.h"
#include "reference/bound.h"
#include "reference/refit.h"
#include "support/meshes.h"

namespace dgm::bench {
namespace {
/// z = a x y over [-1, 1]^2, `cells` x `cells` quads.
model::TriMesh saddle(std::uint32_t cells, double a) {
    model::TriMesh mesh = test::grid_sheet(cells, cells, 2, 2);
    for (auto& p : mesh.positions) p = {p.x - 1, p.y - 1, a * (p.x - 1) * (p.y - 1)};
    return mesh;
}
}  // namespace

TEST(ApproximationBound, ASaddleHasItsIntegral) {
    // K = -a^2 / (1 + a^2 r^2)^2 and dA = sqrt(1 + a^2 r^2) dx dy, summed at the middles of 1000 x 1000 squares.
    for (const double a : {0.1, 1.0}) {
        double integral = 0, area = 0;
        constexpr int n = 1000;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) {
                const double x = (2.0 * i + 1) / n - 1, y = (2.0 * j + 1) / n - 1, g = 1 + a * a * (x * x + y * y);
                integral += std::cbrt(a * a / (g * g) / 90) * std::sqrt(g) * 4 / (n * n);
                area += std::sqrt(g) * 4 / (n * n);
            }
        const double expected = std::sqrt(integral * integral * integral / area) / 5000;
        EXPECT_NEAR(least_rms(saddle(200, a), 5000) / expected, 1, 0.01) << a;
    }
}

TEST(ApproximationBound, ATorusTakesBothSigns) {
    // Of radii R > r: K dA = cos t dt du, dA = r (R + r cos t) dt du; the sum over t is taken in closed steps.
    constexpr std::uint32_t a = 300, b = 150;
    constexpr double big = 3, small = 1, pi = std::numbers::pi;
    const model::TriMesh mesh = test::torus(big, small, a, b);
    double integral = 0;
    constexpr int n = 100000;
    for (int k = 0; k < n; ++k) {
        const double t = 2 * pi * (k + 0.5) / n, c = std::cos(t), d = small * (big + small * c);
        integral += 2 * pi * d * std::cbrt(std::abs(c) / d / (c > 0 ? 180 : 90)) * 2 * pi / n;
    }
    const double area = 4 * pi * pi * big * small;
    EXPECT_NEAR(least_rms(mesh, 8000) / (std::sqrt(integral * integral * integral / area) / 8000), 1, 0.003);
}

TEST(ApproximationBound, ASphereByHand) {
    // K = 1 / R^2 and A = 4 pi R^2 give rms = 4 pi R / (sqrt(180) T).
    constexpr double radius = 2.5;
    const double expected = 4 * std::numbers::pi * radius / (std::sqrt(180.0) * 8000);
    EXPECT_NEAR(least_rms(test::icosphere(5, radius), 8000) / expected, 1, 0.01);
}

bake::SurfaceError error_of(const model::TriMesh& source, const model::TriMesh& mesh) {
    return bake::measure_surface_error(source, mesh);
}

/// A ball seen through so few triangles that interpolation is off everywhere, and to one side.
TEST(Refit, ABallGetsItsBestRadius) {
    const model::TriMesh source = test::icosphere(6), coarse = test::icosphere(3);
    const bake::ClosestPointIndex index(source.positions, source.faces);
    const Refitted fitted = refit(source, index, coarse);
    EXPECT_GT(fitted.rounds, 0);
    const double before = error_of(source, coarse).rms, after = error_of(source, fitted.mesh).rms;
    // 4/45 of |K| a^2 interpolated, 1/180 fitted, where triangles are alike: a quarter.
    EXPECT_LT(after, 0.3 * before);
    EXPECT_GT(after, 0.95 * least_rms(source, coarse.faces.size()));
    EXPECT_LT(after, 1.4 * least_rms(source, coarse.faces.size()));
}

TEST(Refit, NeverLosesAndKeepsTheSurface) {
    const std::pair<model::TriMesh, model::TriMesh> pairs[] = {
        {test::torus(3, 1, 120, 60), test::torus(3, 1, 24, 12)},
        {saddle(80, 1.0), saddle(10, 1.0)},
        {test::genus_plate(2, 4), test::genus_plate(2, 1)},
    };
    for (const auto& [source, coarse] : pairs) {
        const bake::ClosestPointIndex index(source.positions, source.faces);
        const Refitted fitted = refit(source, index, coarse, 4);
        EXPECT_LE(fitted.after.rms, fitted.before.rms);
        const bake::Topology was = bake::measure_topology(coarse), is = bake::measure_topology(fitted.mesh);
        EXPECT_EQ(is.genus, was.genus);
        EXPECT_EQ(is.boundary_loops, was.boundary_loops);
        EXPECT_EQ(fitted.mesh.faces.size(), coarse.faces.size());
    }
}

/// Two faces of a folded sheet that lie across the fold instead of along it.
TEST(Refit, FlipsAnEdgeThatRunsAcrossAFold) {
    model::TriMesh source;
    source.positions = {{0, 0, 0}, {1, 0, 1}, {2, 0, 0}, {0, 1, 0}, {1, 1, 1},
                        {2, 1, 0}, {0, 2, 0}, {1, 2, 1}, {2, 2, 0}};
    for (const std::uint32_t r : {0u, 3u})
        for (const std::uint32_t c : {0u, 1u}) {
            source.faces.push_back({r + c, r + c + 1, r + c + 4});
            source.faces.push_back({r + c, r + c + 4, r + c + 3});
        }
    // The middle of the fold is missing: its neighbours share six faces, one of which spans the fold.
    model::TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 1}, {2, 0, 0}, {2, 2, 0}, {1, 2, 1}, {0, 2, 0}};
    mesh.faces = {{0, 1, 5}, {1, 2, 5}, {2, 4, 5}, {2, 3, 4}};
    const bake::ClosestPointIndex index(source.positions, source.faces);
    const Refitted fitted = refit(source, index, mesh, 3);
    EXPECT_EQ(fitted.flips, 1);
    EXPECT_LT(fitted.after.rms, 1e-6);
    EXPECT_GT(fitted.before.rms, 0.1);
}
}  // namespace dgm::bench
