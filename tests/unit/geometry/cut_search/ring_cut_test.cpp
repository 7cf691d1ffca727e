// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/cut_search/ring_cut_test.cpp
// Cuts of tubes, whose shortest paths are known, and charts of tubes that unroll exactly.
#include "geometry/cut_search/ring_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "geometry/chart/square_chart.h"
#include "geometry/cut_search/component_search.h"
#include "geometry/cut_search/cut_search.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/repair/repair.h"
#include "model/codes.h"
#include "support/chart_checks.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(RingCut, RingsHaveTwoLoopsTwoSidesAndNoHandles) {
    EXPECT_TRUE(is_ring(test::tube(1, 2, 3, 12, 4)));
    EXPECT_TRUE(is_ring(test::annulus(1, 2, 12, 3)));
    TriMesh handle = test::torus(1, 0.4, 32, 16);
    handle.faces.erase(handle.faces.begin() + 400, handle.faces.begin() + 402);
    handle.faces.erase(handle.faces.begin() + 100, handle.faces.begin() + 102);
    const std::array<std::array<std::uint32_t, 2>, 2> holes{{{1, 1}, {5, 3}}};
    for (const TriMesh& mesh : {handle, test::icosphere(1), test::grid_sheet(4, 4), test::sheet_with_holes(7, holes),
                                test::torus(1, 0.4, 16, 9), repair(test::moebius(30, 4)).components[0]}) {
        EXPECT_FALSE(is_ring(mesh));
        EXPECT_TRUE(ring_cuts(mesh, 4).empty());
    }
    EXPECT_TRUE(ring_cuts(test::tube(1, 2, 3, 12, 4), 0).empty());
}

/// Vertices of the cut that lie on the loop at z.
std::size_t touches(const CutGraph& cut, double z) {
    std::set<std::uint32_t> out;
    for (std::uint32_t h = 0; h < cut.opposite().size(); ++h)
        if (cut.is_cut(h))
            for (const std::uint32_t v : {origin(cut.mesh().faces, h), target(cut.mesh().faces, h)})
                if (cut.mesh().positions[v].z == z) out.insert(v);
    return out.size();
}

TEST(RingCut, TheFirstPathIsTheShortestAndTheOthersAreSpread) {
    const TriMesh mesh = test::tube(1, 0.4, 3, 24, 9);
    const std::vector<CutGraph> cuts = ring_cuts(mesh, 6);
    ASSERT_EQ(cuts.size(), 6u);
    std::set<std::uint32_t> starts;
    for (const CutGraph& cut : cuts) {
        EXPECT_TRUE(cut.opens_to_disk());
        EXPECT_NEAR(cut.length(), std::hypot(0.6, 3.0), 1e-12) << "straight down the cone";
        EXPECT_EQ(touches(cut, 0), 1u);
        EXPECT_EQ(touches(cut, 3), 1u);
        for (std::uint32_t v = 0; v < 24; ++v)
            for (std::uint32_t a = cut.graph().first[v]; a < cut.graph().first[v + 1]; ++a)
                if (cut.is_cut(cut.graph().arcs[a].half_edge)) starts.insert(v);
    }
    ASSERT_EQ(starts.size(), 6u);
    for (const std::uint32_t s : starts) EXPECT_EQ(s % 4, *starts.begin() % 4) << "24 places, 6 cuts";
}

TEST(RingCut, TheShortestPathComesFirst) {
    TriMesh mesh = test::tube(1, 1, 3, 24, 9);
    for (model::Vec3d& p : mesh.positions) p.z *= 1 + 0.3 * p.x;  // shortest where x = -1
    const std::vector<CutGraph> cuts = ring_cuts(mesh, 5);
    ASSERT_EQ(cuts.size(), 5u);
    EXPECT_NEAR(cuts[0].length(), 0.7 * 3, 1e-12);
    for (const CutGraph& cut : cuts) EXPECT_GE(cut.length(), cuts[0].length());
}

TEST(RingCut, ABandOfOneRowIsCutAlongAnEdge) {
    const TriMesh band = test::tube(1, 1, 0.1, 8, 1);
    const std::vector<CutGraph> cuts = ring_cuts(band, 3);
    ASSERT_FALSE(cuts.empty());
    for (const CutGraph& cut : cuts) {
        EXPECT_NEAR(cut.length(), 0.1, 1e-12);
        EXPECT_TRUE(cut.opens_to_disk());
    }
}

CutSearchOptions ring_options(std::uint32_t m, std::uint32_t n) {
    CutSearchOptions options;
    options.m = m;
    options.n = n;
    options.rings = 4;
    return options;
}

SampledChart ring_chart(const TriMesh& mesh, std::uint32_t m, std::uint32_t n) {
    const CutSearchResult cut = search_cut(mesh, ring_options(m, n), {});
    EXPECT_TRUE(faces_loops(cut.shares));
    return make_square_chart(cut.disk, m, n, cut.rotation, *make_stretch_parameterizer(8, Levelling::kArea), {},
                             cut.shares);
}

/// A tube of flat facets is a rectangle rolled up: it unrolls to its own plane, point for point, so that the singular
/// values are those of the rectangle, and a grid with a line on each edge between facets has no error.
TEST(RingChart, ATubeUnrollsExactly) {
    const std::uint32_t around = 16;
    const double height = 3, side = 2 * std::sin(kPi / around);
    const TriMesh mesh = test::tube(1, 1, height, around, 12);
    const SampledChart chart = ring_chart(mesh, 33, 25);
    for (const Face& f : chart.disk->mesh.faces)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = f[k], b = f[(k + 1) % 3];
            const model::Vec2d d = chart.uv[b] - chart.uv[a];
            const double flat = std::hypot(d.x * around * side, d.y * height),
                         other = std::hypot(d.y * around * side, d.x * height);
            const double edge = length(chart.disk->mesh.positions[b] - chart.disk->mesh.positions[a]);
            EXPECT_NEAR(std::min(std::abs(flat - edge), std::abs(other - edge)), 0, 1e-4);
        }
    EXPECT_LT(quick_error(mesh, chart, 20'000).hausdorff, 1e-5);
    test::expect_topology(chart, mesh);
}

TEST(RingChart, LoopsLieOnTheLongerSidesOfTheGridWhereTheyAreLonger) {
    const CutSearchResult band = search_cut(test::tube(1, 1, 0.5, 48, 6), ring_options(65, 17), {});
    EXPECT_EQ(band.shares, BorderShares::kLoopsOnM);
    const CutSearchResult turned = search_cut(test::tube(1, 1, 0.5, 48, 6), ring_options(17, 65), {});
    EXPECT_EQ(turned.shares, BorderShares::kLoopsOnN);
    EXPECT_NEAR(band.rms, turned.rms, 1e-3 * band.rms);
}

TEST(RingChart, OtherSurfacesAreRefused) {
    try {
        (void)search_cut(test::icosphere(2), ring_options(33, 33), {});
        FAIL() << "accepted";
    } catch (const model::Error& e) { EXPECT_EQ(e.code().number, model::codes::kMethodUnsuited.number); }
}

TEST(RingChart, ALargeRingIsSearchedOnASimplerOne) {
    TriMesh mesh = test::tube(1, 0.6, 3, 120, 80);  // 19,200 faces
    for (model::Vec3d& p : mesh.positions) p.x += 0.4 * std::sin(p.z);
    const CutSearchResult cut = search_cut(mesh, ring_options(65, 65), {});
    EXPECT_TRUE(faces_loops(cut.shares));
    test::expect_links(cut.disk);
    test::expect_disk(cut.disk);
    EXPECT_LT(cut.cut_length, 1.15 * std::hypot(0.4, 3.0) + 0.2);
}

}  // namespace
}  // namespace dgm::bake
