// SPDX-License-Identifier: GPL-3.0-or-later
// tests/support/disk_checks.h
// Laws of every opened surface, counted here rather than asked of the code under test.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "geometry/cut/disk.h"

namespace dgm::test {

using bake::kNone;

/// Links are involutions, run against each other (mates also in the same direction) and end at the same points; every
/// border edge has none or a mate.
inline void expect_links(const bake::Disk& disk) {
    const auto& faces = disk.mesh.faces;
    ASSERT_EQ(disk.opposite.size(), 3 * faces.size());
    ASSERT_EQ(disk.mate.size(), 3 * faces.size());
    ASSERT_EQ(disk.weld.size(), disk.mesh.positions.size());
    for (std::uint32_t h = 0; h < disk.opposite.size(); ++h) {
        const std::uint32_t a = faces[h / 3][h % 3], b = faces[h / 3][(h + 1) % 3];
        ASSERT_LT(disk.weld[a], disk.weld_count);
        if (const std::uint32_t o = disk.opposite[h]; o != kNone) {
            ASSERT_EQ(disk.mate[h], kNone) << "half-edge " << h;
            ASSERT_EQ(disk.opposite[o], h);
            ASSERT_EQ(faces[o / 3][o % 3], b);
            ASSERT_EQ(faces[o / 3][(o + 1) % 3], a);
        } else if (const std::uint32_t m = disk.mate[h]; m != kNone) {
            ASSERT_EQ(disk.mate[m], h);
            ASSERT_EQ(disk.opposite[m], kNone);
            std::uint32_t c = faces[m / 3][m % 3], d = faces[m / 3][(m + 1) % 3];
            if (disk.same_way(h)) std::swap(c, d);  // where a surface without an inside was opened
            ASSERT_EQ(disk.weld[c], disk.weld[b]);
            ASSERT_EQ(disk.weld[d], disk.weld[a]);
            ASSERT_EQ(disk.mesh.positions[c], disk.mesh.positions[b]);
            ASSERT_EQ(disk.mesh.positions[d], disk.mesh.positions[a]);
        }
    }
}

/// Connected, Euler characteristic 1, and one border cycle that has every border edge once.
inline void expect_disk(const bake::Disk& disk) {
    const auto& faces = disk.mesh.faces;
    std::size_t open = 0, inner = 0;
    for (std::uint32_t o : disk.opposite) (o == kNone ? open : inner) += 1;
    ASSERT_EQ(inner % 2, 0u);
    const auto euler = static_cast<long>(disk.mesh.positions.size()) - static_cast<long>(open + inner / 2) +
                       static_cast<long>(faces.size());
    EXPECT_EQ(euler, 1);
    std::vector<char> used(disk.mesh.positions.size(), 0);
    for (const auto& f : faces)
        for (std::uint32_t v : f) used[v] = 1;
    EXPECT_EQ(std::count(used.begin(), used.end(), 0), 0) << "unused vertices";
    std::vector<char> reached(faces.size(), 0);
    std::vector<std::uint32_t> stack{0};
    reached[0] = 1;
    while (!stack.empty()) {
        const std::uint32_t f = stack.back();
        stack.pop_back();
        for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h)
            if (disk.opposite[h] != kNone && !reached[disk.opposite[h] / 3]) {
                reached[disk.opposite[h] / 3] = 1;
                stack.push_back(disk.opposite[h] / 3);
            }
    }
    EXPECT_EQ(std::count(reached.begin(), reached.end(), 0), 0) << "faces cut off";
    const std::vector<std::uint32_t> border = disk.border();
    EXPECT_EQ(border.size(), open);
    EXPECT_EQ(std::set<std::uint32_t>(border.begin(), border.end()).size(), border.size());
    std::set<std::uint32_t> corners;
    for (std::size_t k = 0; k < border.size(); ++k) {
        const std::uint32_t h = border[k], g = border[(k + 1) % border.size()];
        ASSERT_EQ(disk.opposite[h], kNone);
        ASSERT_EQ(faces[h / 3][(h + 1) % 3], faces[g / 3][g % 3]) << "border edge " << k;
        corners.insert(faces[h / 3][h % 3]);
    }
    EXPECT_EQ(corners.size(), border.size()) << "the border passes a vertex twice";
}

}  // namespace dgm::test
