// SPDX-License-Identifier: GPL-3.0-or-later
// tests/support/chart_checks.h
// Laws of every sampled chart, counted here rather than asked of the code under test.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "geometry/chart/sampled_chart.h"
#include "geometry/metrics/map_metrics.h"
#include "support/disk_checks.h"
#include "support/meshes.h"

namespace dgm::test {

/// Triangles of the chart's surface through its classes.
inline std::vector<Face> welded_faces(const bake::SampledChart& chart) {
    std::vector<Face> faces = chart.faces();
    for (Face& f : faces)
        for (std::uint32_t& s : f) s = chart.representative[s];
    return faces;
}

/// One to one: every face counter-clockwise by exact sign, and together they fill what the border encloses.
inline void expect_bijective(const bake::SampledChart& chart) {
    const auto& faces = chart.disk->mesh.faces;
    ASSERT_EQ(chart.uv.size(), chart.disk->mesh.positions.size());
    double filled = 0, enclosed = 0;
    for (const Face& f : faces) {
        ASSERT_GT(bake::orient2d(chart.uv[f[0]], chart.uv[f[1]], chart.uv[f[2]]), 0);
        filled += 0.5 * cross(chart.uv[f[1]] - chart.uv[f[0]], chart.uv[f[2]] - chart.uv[f[0]]);
    }
    for (std::uint32_t h : chart.disk->border())
        enclosed += 0.5 * cross(chart.uv[bake::origin(faces, h)], chart.uv[bake::target(faces, h)]);
    EXPECT_NEAR(filled, enclosed, 1e-9);
    if (chart.domain == layout::Domain::kSquare) { EXPECT_NEAR(filled, 1, 1e-9); }
}

/// Classes: the lowest sample represents, copies are equal to the bit, samples are where the map says.
inline void expect_classes(const bake::SampledChart& chart) {
    ASSERT_EQ(chart.representative.size(), chart.samples.size());
    ASSERT_EQ(chart.positions.size(), chart.samples.size());
    for (std::uint32_t s = 0; s < chart.samples.size(); ++s) {
        if (!chart.on_surface(s)) continue;
        const std::uint32_t rep = chart.representative[s];
        ASSERT_LE(rep, s);
        ASSERT_EQ(chart.representative[rep], rep);
        ASSERT_EQ(chart.positions[s], chart.positions[rep]);
        ASSERT_LT(chart.samples[s].face, chart.disk->mesh.faces.size());
        ASSERT_LT(length(bake::position_at(chart.disk->mesh, chart.samples[s]) - chart.positions[s]), 1e-9);
    }
}

/// The welded surface is the manifold that the source is, with every sample of the surface in it.
inline void expect_topology(const bake::SampledChart& chart, const TriMesh& source) {
    const std::vector<Face> faces = welded_faces(chart);
    const bake::Topology got = bake::measure_topology(chart.positions.size(), faces);
    const bake::Topology want = bake::measure_topology(source.positions.size(), source.faces);
    EXPECT_TRUE(got.manifold);
    EXPECT_TRUE(got.oriented);
    EXPECT_EQ(got.degenerate_faces, 0u);
    EXPECT_EQ(got.components, want.components);
    EXPECT_EQ(got.boundary_loops, want.boundary_loops);
    EXPECT_EQ(got.genus, want.genus);
    // Each edge has two faces that pass it in opposite directions, or one, and then it is the source's real border.
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
    for (const Face& f : faces)
        for (int k = 0; k < 3; ++k) ++directed[{f[k], f[(k + 1) % 3]}];
    std::size_t open = 0;
    for (const auto& [edge, uses] : directed) {
        EXPECT_EQ(uses, 1) << edge.first << "-" << edge.second;
        open += directed.count({edge.second, edge.first}) == 0;
    }
    EXPECT_EQ(open > 0, want.boundary_loops > 0);
    std::vector<char> used(chart.positions.size(), 0);
    for (const Face& f : faces)
        for (std::uint32_t s : f) used[s] = 1;
    for (std::uint32_t s = 0; s < chart.positions.size(); ++s)
        if (chart.on_surface(s)) { ASSERT_TRUE(used[chart.representative[s]]) << "sample " << s << " hangs loose"; }
}

}  // namespace dgm::test
