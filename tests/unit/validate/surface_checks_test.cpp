// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/validate/surface_checks_test.cpp
// The validator measures the topology of a square grid along the border alone: the same as that of the whole.
#include "validate/surface_checks.h"

#include <gtest/gtest.h>

#include <functional>
#include <numeric>

#include "unit/geometry/metrics/test_charts.h"

namespace dgm::validate {
namespace {
using bake::Topology;
using model::Chart;
using model::ElementType;

/// Samples along the border, counter-clockwise in (u, v) from sample (0, 0).
std::vector<std::uint32_t> border_of(std::uint32_t m, std::uint32_t n) {
    std::vector<std::uint32_t> out;
    for (std::uint32_t i = 0; i + 1 < m; ++i) out.push_back(i * n);
    for (std::uint32_t j = 0; j + 1 < n; ++j) out.push_back((m - 1) * n + j);
    for (std::uint32_t i = m - 1; i > 0; --i) out.push_back(i * n + n - 1);
    for (std::uint32_t j = n - 1; j > 0; --j) out.push_back(j);
    return out;
}

/// A flat grid whose border samples are joined as `join` says: pairs of places along the border.
Chart grid_chart(std::uint32_t m, std::uint32_t n, const std::vector<std::pair<std::size_t, std::size_t>>& join) {
    Chart chart;
    chart.rows = m;
    chart.cols = n;
    chart.method = "tutte";
    chart.bbox = {0, 0, 0, m - 1.0, n - 1.0, 0};
    std::vector<float> xyz;
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < n; ++j)
            xyz.insert(xyz.end(), {static_cast<float>(i), static_cast<float>(j), 0.f});
    chart.layers.push_back(test::make_layer<float>("geometry", ElementType::kF32, {m, n, 3}, xyz));

    const std::vector<std::uint32_t> border = border_of(m, n);
    std::vector<std::uint32_t> root(std::size_t{m} * n);
    std::iota(root.begin(), root.end(), 0u);
    const std::function<std::uint32_t(std::uint32_t)> find = [&](std::uint32_t x) {
        return root[x] == x ? x : root[x] = find(root[x]);
    };
    for (const auto& [a, b] : join) {
        const std::uint32_t x = find(border[a % border.size()]), y = find(border[b % border.size()]);
        root[std::max(x, y)] = std::min(x, y);
    }
    std::vector<std::uint32_t> pairs;
    for (std::uint32_t s = 0; s < root.size(); ++s)
        if (find(s) != s) pairs.insert(pairs.end(), {find(s), s});
    chart.layers.push_back(test::make_layer<std::uint32_t>("seams", ElementType::kU32, {pairs.size() / 2, 2}, pairs));
    return chart;
}

Topology along_border(const Chart& chart) {
    FindingList ignored;
    return check_surface(chart, 0, bake::reconstruct(chart, bake::Corners::kSkip), ignored);
}
Topology of_all(const Chart& chart) {
    const bake::Reconstruction r = bake::reconstruct(chart, bake::Corners::kSkip);
    return bake::measure_topology(r.mesh.positions.size(), r.welded_faces);
}

/// The sides of the square glued in pairs, side s forward to side t backward (or forward, for a twist).
using Gluing = std::vector<std::tuple<int, int, bool>>;
Chart glued(std::uint32_t side, const Gluing& gluing) {
    const std::size_t steps = side - 1;
    std::vector<std::pair<std::size_t, std::size_t>> join;
    for (const auto& [s, t, twisted] : gluing)
        for (std::size_t k = 0; k <= steps; ++k)
            join.emplace_back(static_cast<std::size_t>(s) * steps + k,
                              static_cast<std::size_t>(t) * steps + (twisted ? k : steps - k));
    return grid_chart(side, side, join);
}

TEST(BorderTopology, KnownSurfaces) {
    const auto expect = [](const Chart& chart, std::uint64_t loops, std::int64_t genus, bool oriented) {
        const Topology t = along_border(chart);
        EXPECT_TRUE(t.manifold);
        EXPECT_EQ(t.oriented, oriented);
        EXPECT_EQ(t.components, 1u);
        EXPECT_EQ(t.boundary_loops, loops);
        EXPECT_EQ(t.genus, genus);  // crosscaps, where there is one side
        EXPECT_EQ(t, of_all(chart));
    };
    for (const std::uint32_t side : {4u, 5u, 9u, 12u}) {
        SCOPED_TRACE(side);
        expect(glued(side, {}), 1, 0, true);                              // disk
        expect(glued(side, {{0, 2, false}}), 2, 0, true);                 // tube
        expect(glued(side, {{0, 2, true}}), 1, 1, false);                 // Moebius strip
        if (side < 5) continue;                                           // the others need room for their corners
        expect(glued(side, {{0, 2, false}, {1, 3, false}}), 0, 1, true);  // torus
        // A sphere: the border folded over at the middles of two sides. At a corner, two triangles would be one.
        const std::size_t steps = side - 1;
        std::vector<std::pair<std::size_t, std::size_t>> fold;
        for (std::size_t k = 1; k < 2 * steps; ++k) fold.emplace_back(steps / 2 + k, steps / 2 + 4 * steps - k);
        expect(grid_chart(side, side, fold), 0, 0, true);
    }
}

TEST(BorderTopology, IsThatOfTheWholeForAnyGluing) {
    std::uint64_t state = 7;
    const auto below = [&](std::uint64_t bound) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        return (state >> 33) % bound;
    };
    int manifold = 0;
    for (int round = 0; round < 600; ++round) {
        const auto m = static_cast<std::uint32_t>(2 + below(9)), n = static_cast<std::uint32_t>(2 + below(9));
        const std::size_t border = border_of(m, n).size();
        std::vector<std::pair<std::size_t, std::size_t>> join;
        // Stretches of the border, run against each other; some rounds end in pinches, folds and worse.
        for (std::uint64_t stretches = below(4); stretches-- > 0;) {
            const std::size_t a = below(border), b = below(border), length = below(border / 3 + 1);
            const bool twisted = below(8) == 0;
            for (std::size_t k = 0; k <= length; ++k) join.emplace_back(a + k, b + (twisted ? k : border - k));
        }
        const Chart chart = grid_chart(m, n, join);
        const Topology border_only = along_border(chart), whole = of_all(chart);
        EXPECT_EQ(border_only, whole) << round << ": " << m << " x " << n;
        if (whole.manifold) ++manifold;
    }
    EXPECT_GT(manifold, 100);
}

}  // namespace
}  // namespace dgm::validate
