// SPDX-License-Identifier: GPL-3.0-or-later
// tests/property/free_chart_corner_cases_test.cpp
// Free charts whose cut ends inside: short cuts, sharp ends, flat slits.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "geometry/cgal/border_simple.h"
#include "geometry/cgal/constrained_triangulation.h"
#include "geometry/chart/free_chart.h"
#include "geometry/cut/cut_graph.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/parameterize/free_methods.h"
#include "geometry/repair/repair.h"
#include "support/chart_checks.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

SampledChart chart_of(const TriMesh& mesh, const std::vector<std::uint32_t>& joined, std::uint32_t m, std::uint32_t n,
                      const char* method) {
    CutGraph cut(mesh);
    cut.cut_to_disk();
    for (std::uint32_t v : joined) cut.join(v);
    return make_free_chart(cut.open(), m, n, *make_free_parameterizer(method),
                           {border_is_simple, constrained_triangulation}, {});
}

/// Strip triangles that lie clockwise in (u, v), beyond what rounding to float moves.
std::size_t turned_strip_faces(const SampledChart& chart) {
    const auto place = [&](std::uint32_t s) {
        if (s >= chart.grid_count()) return chart.border_uv[s - chart.grid_count()];
        return Vec2d{double(s / chart.n) / (chart.m - 1), double(s % chart.n) / (chart.n - 1)};
    };
    return static_cast<std::size_t>(std::count_if(chart.strip.begin(), chart.strip.end(), [&](const Face& f) {
        return cross(place(f[1]) - place(f[0]), place(f[2]) - place(f[0])) < -1e-9;
    }));
}

/// The chord across the end of a cut has one surface point at both its ends; it must be flipped away, though the chords
/// beside it cannot be.
TEST(FreeChartCornerCases, SharpEndsOfCuts) {
    const TriMesh finger = repair(test::finger(0.1, 2, 8, 12, 3)).components.at(0);
    ASSERT_NO_FATAL_FAILURE(test::expect_topology(chart_of(finger, {56}, 8, 30, "lscm"), finger));
    ASSERT_NO_FATAL_FAILURE(test::expect_topology(chart_of(finger, {63, 14}, 44, 12, "lscm"), finger));
    const TriMesh triangle = repair(test::polygon_disk(3)).components.at(0);
    ASSERT_NO_FATAL_FAILURE(test::expect_topology(chart_of(triangle, {2, 3, 0}, 12, 38, "lscm"), triangle));
}

/// A tetrahedron is opened along one edge: its disk has two vertices on the border, joined by two different edges.
TEST(FreeChartCornerCases, CutOfASingleEdge) {
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    mesh = repair(mesh).components.at(0);
    for (const char* method : {"arap", "lscm"}) {
        const SampledChart chart = chart_of(mesh, {}, 25, 33, method);
        ASSERT_NO_FATAL_FAILURE(test::expect_bijective(chart));
        ASSERT_NO_FATAL_FAILURE(test::expect_topology(chart, mesh));
    }
}

/// A slit in a flat sheet has both its sides in one place in an isometric map: it must not count as a simple border.
TEST(FreeChartCornerCases, CutOfAFlatSheet) {
    const TriMesh sheet = repair(test::grid_sheet(5, 5)).components.at(0);
    for (std::uint32_t v = 0; v < sheet.positions.size(); ++v)
        for (const char* method : {"arap", "lscm"}) {
            SCOPED_TRACE(std::to_string(v) + " " + method);
            const SampledChart chart = chart_of(sheet, {v}, 39, 38, method);
            ASSERT_NO_FATAL_FAILURE(test::expect_topology(chart, sheet));
        }
}

/// Flips of chords that repeat an edge keep the strip a triangulation of the plane.
TEST(FreeChartCornerCases, StripsAreNotTurnedOver) {
    const TriMesh finger = repair(test::finger(0.1, 2, 8, 12, 3)).components.at(0);
    const TriMesh sheet = repair(test::grid_sheet(5, 5)).components.at(0);
    for (const std::uint32_t m : {21u, 34u, 55u}) {
        SCOPED_TRACE(m);
        for (std::uint32_t v = 0; v < finger.positions.size(); v += 9) {
            const SampledChart chart = chart_of(finger, {v}, m, 89 - m, "lscm");
            EXPECT_EQ(turned_strip_faces(chart), 0u) << v;
            ASSERT_NO_FATAL_FAILURE(test::expect_topology(chart, finger));
        }
        for (std::uint32_t v = 0; v < sheet.positions.size(); ++v)
            EXPECT_EQ(turned_strip_faces(chart_of(sheet, {v}, m, m, "arap")), 0u) << v;
    }
}

/// Loops about many handles leave a ragged disk whose border, put on a circle, crowds what is behind it.
TEST(FreeChartCornerCases, ManyHandlesSpread) {
    std::vector<std::array<int, 3>> lattice;
    for (int x = 0; x < 7; ++x)
        for (int y = 0; y < 7; ++y)
            for (int z = 0; z < 7; ++z)
                if (x % 2 + y % 2 + z % 2 <= 1) lattice.push_back({x, y, z});
    const TriMesh mesh = repair(test::cubes(lattice, 2)).components.at(0);  // genus 144 bars - 64 joints + 1
    const SampledChart chart = chart_of(mesh, {}, 257, 257, "arap");
    ASSERT_NO_FATAL_FAILURE(test::expect_topology(chart, mesh));
    EXPECT_LT(measure_map(chart.disk->mesh.positions, chart.disk->mesh.faces, chart.uv).stretch_l2, 2);
}

/// Where cells are wider than the limbs between cuts, no flip of chords makes the welded strip a surface; border
/// samples more beside them do.
TEST(FreeChartCornerCases, ManyHandlesOnASmallGrid) {
    std::vector<std::array<int, 3>> cells;
    for (int x = 0; x < 19; ++x)
        for (int y = 0; y < 19; ++y)
            if (x % 2 == 0 || y % 2 == 0) cells.push_back({x, y, 0});
    const TriMesh plate = repair(test::cubes(cells)).components.at(0);  // genus 81
    for (const std::uint32_t side : {17u, 25u}) {
        SCOPED_TRACE(side);
        ASSERT_NO_FATAL_FAILURE(test::expect_topology(chart_of(plate, {}, side, side, "arap"), plate));
    }
}

}  // namespace
}  // namespace dgm::bake
