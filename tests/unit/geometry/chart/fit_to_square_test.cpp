// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/chart/fit_to_square_test.cpp
#include "geometry/chart/fit_to_square.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/cut/cut_graph.h"

namespace dgm::bake {
namespace {

/// Teeth side by side on a thin back, as high as the unit square, and their own map.
Disk comb(std::uint32_t teeth, std::vector<Vec2d>& uv) {
    TriMesh mesh;
    for (std::uint32_t k = 0; k <= teeth; ++k) {
        mesh.positions.push_back({double(k) / teeth, 0, 0});
        mesh.positions.push_back({double(k) / teeth, 0.01, 0});
    }
    for (std::uint32_t k = 0; k < teeth; ++k) {
        const std::uint32_t a = 2 * k, tip = 2 * (teeth + 1) + k;
        mesh.positions.push_back({(k + 0.5) / teeth, 1, 0});
        mesh.faces.insert(mesh.faces.end(), {{a, a + 2, a + 3}, {a, a + 3, a + 1}, {a + 1, a + 3, tip}});
    }
    const CutGraph uncut(mesh);
    Disk disk = uncut.open();
    for (const Vec3d& p : disk.mesh.positions) uv.push_back({p.x, p.y});
    return disk;
}

/// Of a border edge, in cells of a grid of 65 x 65 samples.
double longest_edge(const Disk& disk, const std::vector<Vec2d>& uv) {
    double longest = 0;
    for (const std::uint32_t h : disk.border()) {
        const Vec2d d = uv[target(disk.mesh.faces, h)] - uv[origin(disk.mesh.faces, h)];
        longest = std::max(longest, 64 * length(d));
    }
    return longest;
}

TEST(DivideBorder, EdgesAreNoLongerThanACell) {
    std::vector<Vec2d> uv;
    Disk disk = comb(100, uv);
    divide_border(disk, uv, 64, 64);
    EXPECT_LE(longest_edge(disk, uv), 1 + 1e-9);
    EXPECT_EQ(uv.size(), disk.mesh.positions.size());
}

TEST(DivideBorder, ALongBorderAddsFourVerticesASampleAndNoMore) {
    std::vector<Vec2d> uv;
    Disk disk = comb(10'000, uv);  // whole, 1.2 million
    const std::size_t before = uv.size();
    divide_border(disk, uv, 64, 64);
    EXPECT_LE(uv.size() - before, 4u * 65 * 65);
    EXPECT_EQ(uv.size(), disk.mesh.positions.size());
    // Where there is room for some, the longest edges get them: 20,000 edges of 64 cells, 16,900 vertices.
    std::vector<Vec2d> half;
    Disk fewer = comb(1'000, half);
    const std::size_t were = half.size();
    divide_border(fewer, half, 64, 64);
    EXPECT_LE(half.size() - were, 4u * 65 * 65);
    EXPECT_LT(longest_edge(fewer, half), 64.0 / 8);
}

}  // namespace
}  // namespace dgm::bake
