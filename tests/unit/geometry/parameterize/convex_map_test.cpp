// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/parameterize/convex_map_test.cpp
// Weighted means, cotangents of known angles, stretch of affine maps by hand.
#include "geometry/parameterize/convex_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "geometry/chart/square_chart.h"
#include "geometry/cut/cut_graph.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/parameterize/square_border.h"
#include "geometry/parameterize/stretch_map.h"
#include "laid_disk.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

TEST(ConvexMap, EveryInnerVertexIsTheWeightedMeanOfItsNeighbours) {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> exponent(-2, 2);
    for (const TriMesh& mesh : {test::grid_sheet(9, 7), test::icosphere(2), test::torus(1, 0.4, 14, 9)}) {
        const test::LaidDisk laid = test::lay(mesh, 17, 2);
        const std::size_t n = laid.disk.mesh.positions.size();
        ConvexMapSolver solver(n, laid.disk.mesh.faces, laid.border.vertices);
        const auto edges = solver.edges();
        for (std::size_t e = 0; e < edges.size(); ++e) {
            EXPECT_LT(edges[e].first, edges[e].second);
            if (e > 0) { EXPECT_LT(edges[e - 1], edges[e]); }
        }
        for (int round = 0; round < 3; ++round) {  // again and again with new weights
            std::vector<double> weights(edges.size());
            for (double& w : weights) w = std::pow(10, exponent(random));
            const std::vector<Vec2d> uv = solver.solve(weights, laid.border.uv);
            ASSERT_EQ(uv.size(), n);
            std::vector<char> fixed(n, 0);
            for (std::size_t k = 0; k < laid.border.vertices.size(); ++k) {
                ASSERT_EQ(uv[laid.border.vertices[k]], laid.border.uv[k]) << "to the bit";
                fixed[laid.border.vertices[k]] = 1;
            }
            std::vector<Vec2d> pull(n);
            std::vector<double> sum(n, 0.0);
            for (std::size_t e = 0; e < edges.size(); ++e) {
                const auto [a, b] = edges[e];
                pull[a] = pull[a] + uv[b] * weights[e];
                sum[a] += weights[e];
                pull[b] = pull[b] + uv[a] * weights[e];
                sum[b] += weights[e];
            }
            for (std::size_t v = 0; v < n; ++v)
                if (!fixed[v]) { ASSERT_LT(length(uv[v] - pull[v] * (1 / sum[v])), 1e-11) << "vertex " << v; }
        }
    }
}

TEST(ConvexMap, NothingInsideNeedsNoSolve) {
    const std::vector<Face> faces{{0, 1, 2}};
    const std::vector<std::uint32_t> border{0, 1, 2};
    const std::vector<Vec2d> uv{{0, 0}, {1, 0}, {1, 1}};
    ConvexMapSolver solver(3, faces, border);
    EXPECT_EQ(solver.solve(std::vector<double>(3, 1.0), uv), uv);
}

TEST(ConvexMap, CotangentsOfKnownAngles) {
    // A rhombus of two equilateral triangles.
    const double h = std::sqrt(3.0) / 2;
    std::vector<Vec3d> positions{{0, 0, 0}, {1, 0, 0}, {0.5, h, 0}, {0.5, -h, 0}};
    const std::vector<Face> faces{{0, 1, 2}, {1, 0, 3}};
    const std::vector<std::pair<std::uint32_t, std::uint32_t>> edges{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}};
    std::vector<double> w = positive_cotangent_weights(positions, faces, edges);
    ASSERT_EQ(w.size(), 5u);
    EXPECT_NEAR(w[0], 1 / std::sqrt(3.0), 1e-14);  // (cot 60 + cot 60) / 2
    for (int e = 1; e < 5; ++e) EXPECT_NEAR(w[e], 0.5 / std::sqrt(3.0), 1e-14);
    // A square: nothing across the diagonal, cot 45 / 2 at the sides.
    positions = {{0, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, 0}};
    w = positive_cotangent_weights(positions, faces, edges);
    EXPECT_EQ(w[0], 0.01);
    for (int e = 1; e < 5; ++e) EXPECT_NEAR(w[e], 0.5, 1e-14);
    // Obtuse (cot 150 is negative) and needle-shaped faces are clamped.
    positions = {{0, 0, 0}, {1, 0, 0}, {0.5, 1e-5, 0}, {0.5, -h, 0}};
    w = positive_cotangent_weights(positions, faces, edges);
    EXPECT_EQ(w[0], 0.01);
    for (double x : w) EXPECT_TRUE(x >= 0.01 && x <= 100);
}

/// The surface point of (s, t) is (a s, b t, 0): S_s = (a, 0, 0), S_t = (0, b, 0), squared L2 stretch (a^2 + b^2) / 2.
TEST(ConvexMap, StretchOfAffineTriangles) {
    const std::vector<Face> faces{{0, 1, 2}};
    const std::vector<Vec2d> uv{{0.1, 0.2}, {0.6, 0.3}, {0.2, 0.9}};
    const double map_area = 0.5 * (0.5 * 0.7 - 0.1 * 0.1);
    const auto energy = [&](double a, double b, double shear) {
        std::vector<Vec3d> positions;
        for (const Vec2d& p : uv) positions.push_back({a * p.x + shear * p.y, b * p.y, 4});
        return stretch_energy(positions, faces, uv) / (a * b * map_area);
    };
    EXPECT_NEAR(energy(1, 1, 0), 1, 1e-13);
    EXPECT_NEAR(energy(3, 2, 0), 6.5, 1e-12);
    EXPECT_NEAR(energy(1, 1, 2), 3, 1e-12);        // S_t = (2, 1): (1 + 5) / 2
    EXPECT_NEAR(energy(0.5, 4, 1), 8.625, 1e-11);  // (0.25 + 1 + 16) / 2
    const std::vector<Vec3d> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const std::vector<Vec2d> flipped{{0, 0}, {0, 1}, {1, 0}}, flat{{0, 0}, {1, 1}, {2, 2}};
    EXPECT_TRUE(std::isinf(stretch_energy(positions, faces, flipped)));
    EXPECT_TRUE(std::isinf(stretch_energy(positions, faces, flat)));
}

TEST(ConvexMap, ReweightingLowersStretchAndNeverFlips) {
    for (const TriMesh& mesh : {test::finger(0.2, 1, 16, 16, 6), test::icosphere(3), test::torus(1, 0.4, 30, 14)}) {
        const test::LaidDisk laid = test::lay(mesh, 33, 2);
        const auto& positions = laid.disk.mesh.positions;
        const auto& faces = laid.disk.mesh.faces;
        ConvexMapSolver solver(positions.size(), faces, laid.border.vertices);
        const std::vector<Vec2d> first =
            solver.solve(positive_cotangent_weights(positions, faces, solver.edges()), laid.border.uv);
        const std::vector<Vec2d> best = reweighted_stretch_map(laid.view(), {}, {});
        const double before = stretch_energy(positions, faces, first), after = stretch_energy(positions, faces, best);
        EXPECT_LT(after, 0.9 * before);
        EXPECT_EQ(measure_map(positions, faces, best).flips, 0u);
        for (std::size_t k = 0; k < laid.border.vertices.size(); ++k)
            ASSERT_EQ(best[laid.border.vertices[k]], laid.border.uv[k]);
        ReweightOptions none;
        none.iterations = 0;
        EXPECT_EQ(reweighted_stretch_map(laid.view(), none, {}), first);
    }
}

/// A square with a ribbon one cell wide and 120 long: every inner edge of the ribbon joins two points of the border,
/// and convex weights crowd it exponentially wherever both its sides lie on one side of the square.
TEST(StretchMap, UncrowdsARibbon) {
    TriMesh mesh;
    constexpr std::uint32_t kBody = 8, kLong = 120;
    const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        mesh.faces.push_back({a, b, c});
        mesh.faces.push_back({a, c, d});
    };
    for (std::uint32_t i = 0; i <= kBody; ++i)
        for (std::uint32_t j = 0; j <= kBody; ++j) mesh.positions.push_back({1.0 * i, 1.0 * j, 0});
    const auto id = [&](std::uint32_t i, std::uint32_t j) { return i * (kBody + 1) + j; };
    for (std::uint32_t i = 0; i < kBody; ++i)
        for (std::uint32_t j = 0; j < kBody; ++j) quad(id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
    std::uint32_t low = id(kBody, 3), high = id(kBody, 4);
    for (std::uint32_t k = 1; k <= kLong; ++k) {
        const auto next = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back({1.0 * kBody + k, 3, 0});
        mesh.positions.push_back({1.0 * kBody + k, 4, 0});
        quad(low, next, next + 1, high);
        low = next;
        high = next + 1;
    }
    double worst_convex = 0;
    for (const std::uint32_t rotation : {0u, 20u, 40u, 60u}) {
        Disk disk = CutGraph(mesh).open();
        const SquareBorder border = lay_square_border(disk, 65, 65, rotation);
        const DiskView view{disk.mesh.positions, disk.mesh.faces, border.vertices, border.uv};
        const MapMetrics convex = measure_map(view.positions, view.faces, reweighted_stretch_map(view, {}, {}));
        worst_convex = std::max(worst_convex, convex.flips > 0 ? 1e9 : convex.stretch_l2);
        const MapMetrics final = measure_map(view.positions, view.faces, stretch_map(view, 8, {}));
        EXPECT_EQ(final.flips, 0u) << rotation;
        EXPECT_LT(final.stretch_l2, 8) << rotation;  // the body has a third of the area, a ninth of the border
    }
    EXPECT_GT(worst_convex, 100) << "not the hard case it is meant to be";
}

/// A flat square that lies on the square already: every map with equal weights for equal edges is the identity.
TEST(ConvexMap, IdentityStaysIdentity) {
    const TriMesh mesh = test::grid_sheet(8, 8);
    Disk disk = CutGraph(mesh).open();
    const SquareBorder border = lay_square_border(disk, 9, 9, 0);
    const std::vector<Vec2d> uv =
        make_stretch_parameterizer(0)->solve({disk.mesh.positions, disk.mesh.faces, border.vertices, border.uv}, {});
    EXPECT_NEAR(stretch_energy(disk.mesh.positions, disk.mesh.faces, uv), 1, 1e-6) << "area 1 times stretch 1";
}

}  // namespace
}  // namespace dgm::bake
