// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/chart/lattice_strip_test.cpp
#include "geometry/chart/lattice_strip.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geometry/cgal/constrained_triangulation.h"

namespace dgm::bake {
namespace {

/// A body of 62 x 20 cells with limbs of `width` cells on it, between the columns of the lattice: each limb is a tube
/// whose two sides are joined, so its triangles have border samples alone for corners.
SampledChart body_with_limbs(int limbs, double width, int samples, std::uint32_t seed) {
    SampledChart chart;
    chart.m = chart.n = 65;
    chart.method = "test";
    chart.domain = layout::Domain::kFree;
    std::mt19937 random(seed);
    const auto shake = [&](double by) { return by * (static_cast<double>(random() % 2001) / 1000.0 - 1); };
    std::vector<Vec2d> border;
    std::vector<std::uint32_t> mate;  // index in `border`, itself if alone
    const auto add = [&](Vec2d p) {
        mate.push_back(static_cast<std::uint32_t>(border.size()));
        border.push_back(p);
    };
    for (int k = 0; k <= 62; ++k) add({1.0 + k, 1.03});
    // Along the top from the right: up one side of each limb, down the other.
    constexpr double kTop = 20.47, kStep = 0.16;
    for (int limb = limbs; limb-- > 0;) {
        const double left = 2 + 3 * limb + 0.5 * (1 - width);
        std::vector<double> heights;
        for (int k = 0; k <= samples; ++k) heights.push_back(kTop + kStep * k + (k > 0 ? shake(0.2 * kStep) : 0));
        const auto first = static_cast<std::uint32_t>(border.size());
        for (const double y : heights) add({left + width + shake(0.02), y});
        add({left + 0.5 * width, kTop + kStep * (samples + 2)});  // the tip
        for (std::size_t k = heights.size(); k-- > 0;) {
            add({left + shake(0.02), heights[k] + shake(0.02)});
            mate.back() = first + static_cast<std::uint32_t>(k);
        }
    }
    const double side = chart.m - 1;
    chart.mask.assign(chart.grid_count(), 0);
    for (std::uint32_t i = 3; i < 60; ++i)
        for (std::uint32_t j = 2; j <= 20; ++j) chart.mask[std::size_t{i} * chart.n + j] = 1;
    const auto grid = static_cast<std::uint32_t>(chart.grid_count());
    for (std::uint32_t s = 0; s < grid; ++s) chart.representative.push_back(s);
    for (std::size_t b = 0; b < border.size(); ++b) {
        chart.border_uv.push_back({border[b].x / side, border[b].y / side});
        chart.representative.push_back(grid + mate[b]);
    }
    chart.positions.resize(chart.representative.size());
    return chart;
}

TEST(LatticeStrip, LimbsWithoutSamplesOfTheLatticeAreTubes) {
    for (const std::uint32_t seed : {1u, 2u, 3u}) {
        SampledChart chart = body_with_limbs(20, 0.6, 150, seed);
        EXPECT_TRUE(join_lattice_to_border(chart, constrained_triangulation).empty()) << seed;
        const Topology topology = welded_topology(chart);
        EXPECT_TRUE(topology.manifold) << seed;
        EXPECT_TRUE(topology.oriented) << seed;
        EXPECT_EQ(topology.degenerate_faces, 0u) << seed;
        EXPECT_EQ(topology.components, 1u) << seed;
        EXPECT_EQ(topology.boundary_loops, 1u) << seed;
        EXPECT_EQ(topology.genus, 0) << seed;
    }
}

}  // namespace
}  // namespace dgm::bake
