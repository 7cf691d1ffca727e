// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/lod_test.cpp
// Level of detail, strips and vertex formats.
#include <gtest/gtest.h>

#include <dgm/reconstruct.h>

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <set>

#include "contact_shapes.h"

namespace dgm::test {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

std::vector<std::uint32_t> indices_of(const State& s, std::uint32_t stride, IndexTopology topology) {
    const ReconstructOptions o{stride, topology};
    const auto counts = mesh_counts(s, o);
    EXPECT_TRUE(counts.ok());
    std::vector<std::uint32_t> indices(counts.value().indices, 77);
    const auto done = reconstruct(s, {}, indices, o);
    EXPECT_TRUE(done.ok());
    EXPECT_EQ(done.value().indices, indices.size());
    EXPECT_NE(indices.back(), 77u);
    return indices;
}

/// Each triangle turned so that its lowest index comes first; degenerate ones left out.
std::multiset<Triangle> triangles_of(const std::vector<std::uint32_t>& indices, IndexTopology topology) {
    std::multiset<Triangle> out;
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (a == b || b == c || a == c) return;
        Triangle t{a, b, c};
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        out.insert(t);
    };
    if (topology == IndexTopology::Triangles) {
        EXPECT_EQ(indices.size() % 3, 0u);
        for (std::size_t k = 0; k + 2 < indices.size(); k += 3) add(indices[k], indices[k + 1], indices[k + 2]);
        return out;
    }
    std::size_t start = 0;
    for (std::size_t k = 0; k < indices.size(); ++k) {
        if (indices[k] == kRestart) {
            start = k + 1;
        } else if (k >= start + 2) {
            const bool odd = (k - start) % 2 != 0;
            add(indices[k - 2 + (odd ? 1 : 0)], indices[k - 2 + (odd ? 0 : 1)], indices[k]);
        }
    }
    return out;
}

/// Every directed edge between welded points as often as its reverse if `closed`, else not more than once. (Two points
/// may have several edges: all four corners of the octahedral chart are one.)
void expect_watertight(const State& s, const std::multiset<Triangle>& triangles, bool closed) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    const auto weld = [&](std::uint32_t k) {
        const std::uint32_t id = s.class_of(k);
        return id == kNone ? k : s.class_members(id)[0];
    };
    for (const Triangle& t : triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = weld(t[k]), b = weld(t[(k + 1) % 3]);
            if (a != b) ++edges[{a, b}];
        }
    for (const auto& [edge, count] : edges) {
        const auto back = edges.find({edge.second, edge.first});
        const int reverse = back == edges.end() ? 0 : back->second;
        if (closed) {
            ASSERT_EQ(count, reverse) << edge.first << " - " << edge.second;
        } else {
            ASSERT_EQ(count, 1) << edge.first << " - " << edge.second;
        }
    }
}

ChartSpec with_diagonals(ChartSpec chart) {
    std::vector<std::uint8_t> bits((chart.rows - 1) * (chart.cols - 1));
    for (std::size_t k = 0; k < bits.size(); ++k) bits[k] = (k * 7 / 3 + k / 11) % 2;
    chart.add("diagonals", ElementType::kU8, {chart.rows - 1, chart.cols - 1}, bits);
    return chart;
}

TEST(Lod, StripsHoldTheTriangles) {
    for (const ChartSpec& chart :
         {with_diagonals(sphere_chart(17)), sphere_chart(17), with_diagonals(free_chart(13, 19, sheet)),
          grid_chart(2, 9, sheet), with_diagonals(grid_chart(9, 2, sheet))}) {
        const State s = make_state(chart);
        for (const std::uint32_t stride : {1u, 2u, 3u, 5u, 100u}) {
            SCOPED_TRACE(stride);
            const auto strips = indices_of(s, stride, IndexTopology::Strips);
            const auto triangles = indices_of(s, stride, IndexTopology::Triangles);
            EXPECT_EQ(triangles_of(strips, IndexTopology::Strips), triangles_of(triangles, IndexTopology::Triangles));
        }
    }
    const State s = make_state(sphere_chart(65));
    EXPECT_LT(indices_of(s, 1, IndexTopology::Strips).size(), 0.4 * indices_of(s, 1, IndexTopology::Triangles).size());
}

TEST(Lod, BordersStayClosedAtAnyStride) {
    const State ball = make_state(with_diagonals(sphere_chart(33)));
    const State flat = make_state(free_chart(21, 30, sheet));
    std::size_t last = ~std::size_t{0};
    for (const std::uint32_t stride : {1u, 2u, 3u, 4u, 5u, 7u, 16u, 31u, 1000u}) {
        SCOPED_TRACE(stride);
        const auto triangles =
            triangles_of(indices_of(ball, stride, IndexTopology::Triangles), IndexTopology::Triangles);
        expect_watertight(ball, triangles, true);
        EXPECT_LE(triangles.size(), last);
        last = triangles.size();
        // A sheet's only open edges are those of its border, the same at all strides.
        const auto sheet_triangles =
            triangles_of(indices_of(flat, stride, IndexTopology::Triangles), IndexTopology::Triangles);
        expect_watertight(flat, sheet_triangles, false);
        std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
        for (const Triangle& t : sheet_triangles)
            for (std::size_t k = 0; k < 3; ++k) edges.insert({t[k], t[(k + 1) % 3]});
        for (const auto& [a, b] : edges)
            if (edges.count({b, a}) == 0) { EXPECT_TRUE(a >= 21 * 30 && b >= 21 * 30) << a << ' ' << b; }
    }
    EXPECT_LT(last, 33u * 33u) << "little but the border is left";
}

TEST(Lod, CoarseTrianglesCoverTheArea) {
    const State s = make_state(grid_chart(38, 51, [](double i, double j) { return Point{float(i), float(j), 0}; }));
    for (const std::uint32_t stride : {1u, 2u, 4u, 9u}) {
        double area = 0;
        for (const Triangle& t :
             triangles_of(indices_of(s, stride, IndexTopology::Triangles), IndexTopology::Triangles)) {
            const Vec3 a = s.positions()[t[0]], b = s.positions()[t[1]] - a, c = s.positions()[t[2]] - a;
            const double twice = double(b.x) * c.y - double(b.y) * c.x;
            EXPECT_GT(twice, 0) << "turned over";
            area += twice / 2;
        }
        EXPECT_EQ(area, 37 * 50);
    }
}

/// By the definition: the nearest of all halves, ties to the even one.
std::uint16_t slow_half(float v) {
    const auto value = [](std::uint32_t h) {
        const std::uint32_t e = h >> 10, m = h & 1023;
        return e == 0 ? std::ldexp(double(m), -24) : std::ldexp(1024.0 + m, int(e) - 25);
    };
    const std::uint16_t sign = std::signbit(v) ? 0x8000 : 0;
    const double size = std::fabs(double(v));
    std::uint32_t low = 0, high = 0x7C00;  // 65536 stands for infinity
    while (high - low > 1) (value((low + high) / 2) <= size ? low : high) = (low + high) / 2;
    const double below = size - value(low), above = value(high) - size;
    const bool up = above < below || (above == below && high % 2 == 0);
    return static_cast<std::uint16_t>(sign | (up ? high : low));
}

TEST(Lod, VertexFormats) {
    std::vector<float> values = {0,    -0.0f, 1,        -1,       65504,   65519, 65520,
                                 1e9f, 6e-8f, 2.98e-8f, 2.99e-8f, 6.1e-5f, 1e-40f};
    for (int k = 0; k < 5000; ++k) values.push_back(std::ldexp(float(std::sin(k * 1.7)), k % 40 - 25));
    while (values.size() % 9 != 0) values.push_back(0.5f);
    const auto n = static_cast<std::uint32_t>(values.size() / 9);
    const State s = make_state(grid_chart(3, n, [&](double i, double j) {
        const std::size_t k = 3 * (std::size_t(i) * n + std::size_t(j));
        return Point{values[k], values[k + 1], values[k + 2]};
    }));
    // A layout of a caller: 22 bytes, f16 position at 4, u16 uv at 18, u16 normal at 11.
    std::vector<std::byte> memory(22 * s.sample_count() + 1, std::byte{0xEE});
    VertexTarget target{{memory.data() + 1, memory.size() - 1}, 22, 4, 11, 18};
    target.position_format = VertexFormat::F16;
    target.normal_format = target.uv_format = VertexFormat::U16;
    ASSERT_TRUE(reconstruct(s, target, {}).ok());
    const auto at = [&](std::uint32_t k, std::size_t offset) {
        std::uint16_t v;
        std::memcpy(&v, memory.data() + 1 + 22 * k + offset, 2);
        return v;
    };
    for (std::uint32_t k = 0; k < s.sample_count(); ++k) {
        for (std::uint32_t a = 0; a < 3; ++a)
            ASSERT_EQ(at(k, 4 + 2 * a), slow_half(values[3 * k + a])) << values[3 * k + a];
        const Vec3 normal = s.normal(k);
        ASSERT_NEAR(at(k, 11) / 65535.0 * 2 - 1, normal.x, 2e-5);
        ASSERT_NEAR(at(k, 15) / 65535.0 * 2 - 1, normal.z, 2e-5);
        ASSERT_NEAR(at(k, 18) / 65535.0, k % n / (n - 1.0), 1e-5);
        ASSERT_EQ(at(k, 20), k / n == 0 ? 0 : k / n == 1 ? 32768 : 65535);
        for (const std::size_t gap : {0, 1, 2, 3, 10, 17})
            ASSERT_EQ(memory[1 + 22 * k + gap], std::byte{0xEE}) << "wrote between attributes";
    }
    State flat = make_state(grid_chart(3, 3, [](double i, double j) { return Point{float(i), float(j), -7}; }));
    std::vector<std::uint16_t> grid(27);
    VertexTarget quantised{std::as_writable_bytes(std::span(grid)), 6, 0};
    quantised.position_format = VertexFormat::U16;
    EXPECT_FALSE(reconstruct(flat, quantised, {}).ok()) << "no steps given";
    quantised.origin = {0.5f, 0, -8};
    quantised.step = {0.01f, 1, 1e-5f};
    ASSERT_TRUE(reconstruct(flat, quantised, {}).ok());
    EXPECT_EQ(grid[0], 0) << "clamped";
    EXPECT_EQ(grid[3 * 6], 150);
    EXPECT_EQ(grid[3 * 2 + 1], 2);
    EXPECT_EQ(grid[2], 65535) << "clamped";
    VertexTarget wrong = quantised;
    wrong.stride = 5;
    EXPECT_FALSE(reconstruct(flat, wrong, {}).ok());
    wrong = quantised;
    wrong.position_format = static_cast<VertexFormat>(3);
    EXPECT_FALSE(reconstruct(flat, wrong, {}).ok());
    EXPECT_FALSE(mesh_counts(flat, {0}).ok());
    EXPECT_FALSE(mesh_counts(flat, {1, static_cast<IndexTopology>(2)}).ok());
}

}  // namespace
}  // namespace dgm::test
