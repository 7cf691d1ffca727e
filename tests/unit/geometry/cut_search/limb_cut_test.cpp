// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/cut_search/limb_cut_test.cpp
// Bodies whose limbs can be counted.
#include "geometry/cut_search/limb_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "geometry/metrics/map_metrics.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

/// Six arms of `reach` cubes along the axes, from a cube in the middle.
TriMesh cross(int reach) {
    std::vector<std::array<int, 3>> cells{{0, 0, 0}};
    for (int k = 1; k <= reach; ++k)
        for (const int s : {-k, k}) cells.insert(cells.end(), {{s, 0, 0}, {0, s, 0}, {0, 0, s}});
    return test::cubes(cells, 2);
}

/// Arms whose end a cut reaches.
std::size_t arms_reached(const TriMesh& mesh, const CutGraph& cut) {
    std::set<int> out;
    const std::vector<char> tips = cut.tips();
    const auto [low, high] = std::minmax_element(mesh.positions.begin(), mesh.positions.end(),
                                                 [](const auto& a, const auto& b) { return a.x < b.x; });
    for (std::size_t v = 0; v < tips.size(); ++v) {
        if (tips[v] == 0) continue;
        const std::array<double, 3> p{mesh.positions[v].x, mesh.positions[v].y, mesh.positions[v].z};
        for (int a = 0; a < 3; ++a) {
            if (p[std::size_t(a)] == low->x) out.insert(2 * a);
            if (p[std::size_t(a)] == high->x) out.insert(2 * a + 1);
        }
    }
    return out.size();
}

TEST(LimbCut, ReachesEachTipOnce) {
    const TriMesh mesh = cross(6);
    const std::optional<CutGraph> cut = limb_cut(mesh, 40, {});
    ASSERT_TRUE(cut);
    EXPECT_TRUE(cut->opens_to_disk());
    EXPECT_EQ(arms_reached(mesh, *cut), 6u);
    const std::vector<char> tips = cut->tips();
    EXPECT_EQ(std::count(tips.begin(), tips.end(), 1), 6) << "and nothing else";
}

TEST(LimbCut, CombsHaveAWayToEachTooth) {
    for (const int teeth : {3, 8}) {
        const TriMesh mesh = test::comb(teeth, 12);
        const std::optional<CutGraph> cut = limb_cut(mesh, 40, {});
        ASSERT_TRUE(cut);
        EXPECT_TRUE(cut->opens_to_disk());
        const std::vector<char> tips = cut->tips();
        EXPECT_EQ(std::count(tips.begin(), tips.end(), 1), teeth);
    }
}

TEST(LimbCut, NoMoreThanAsked) {
    const TriMesh mesh = test::comb(8, 12);
    EXPECT_FALSE(limb_cut(mesh, 3, {})) << "the ways to three of eight teeth are equally long";
}

TEST(LimbCut, OpensLimbsWhereTheBorderHasSamplesForThem) {
    const TriMesh mesh = test::comb(8, 12);
    const std::optional<CutSearchResult> opened = open_limbs(mesh, 33, 33, {});
    ASSERT_TRUE(opened);
    EXPECT_EQ(opened->cut_length, limb_cut(mesh, 40, {})->length());
    const Topology topology = measure_topology(opened->disk.mesh);
    EXPECT_EQ(topology.genus, 0);
    EXPECT_EQ(topology.boundary_loops, 1u);
    EXPECT_FALSE(open_limbs(mesh, 9, 9, {})) << "32 samples of the border for eight limbs";
}

TEST(LimbCut, BallsAndSheetsHaveNone) {
    EXPECT_FALSE(limb_cut(test::icosphere(4), 40, {}));
    EXPECT_FALSE(limb_cut(test::grid_sheet(20, 20), 40, {}));
}

TEST(LimbCut, HandlesAreOpenedToo) {
    const std::optional<CutGraph> cut = limb_cut(test::torus(1, 0.2, 60, 12), 40, {});
    EXPECT_TRUE(!cut || cut->opens_to_disk());
}

}  // namespace
}  // namespace dgm::bake
