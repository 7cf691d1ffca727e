// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/parameterize/flat_map_test.cpp
#include "geometry/parameterize/flat_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "geometry/parameterize/slim.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

using model::Face;
using model::TriMesh;
using model::Vec2d;
using model::Vec3d;

/// A strip of n cells of 1/n x 1, turned out of all planes of two axes: needles where n is large.
TriMesh tilted_strip(std::uint32_t n) {
    TriMesh mesh = test::grid_sheet(n, 1);
    const Vec3d u{2.0 / 3, -1.0 / 3, 2.0 / 3}, v{2.0 / 3, 2.0 / 3, -1.0 / 3};
    for (Vec3d& p : mesh.positions) p = (u * p.x + v * p.y) * std::sqrt(0.5);
    return mesh;
}

TEST(FlatNeedleMap, KeepsAllLengthsOfATiltedPanel) {
    const TriMesh mesh = tilted_strip(2000);
    const auto map = flat_needle_map(mesh.positions, mesh.faces);
    ASSERT_TRUE(map);
    EXPECT_EQ(count_not_positive(mesh.faces, *map), 0u);
    for (std::size_t v = 0; v < mesh.positions.size(); v += 7)
        for (std::size_t w = 0; w < v; w += 501) {
            const Vec2d d = (*map)[v] - (*map)[w];
            ASSERT_NEAR(std::sqrt(dot(d, d)), length(mesh.positions[v] - mesh.positions[w]), 1e-14);
        }
}

TEST(FlatNeedleMap, LeavesOrdinaryPanelsToTheSolvers) {
    const TriMesh mesh = tilted_strip(200);
    EXPECT_FALSE(flat_needle_map(mesh.positions, mesh.faces));
}

TEST(FlatNeedleMap, RefusesWhatIsNotFlat) {
    TriMesh mesh = tilted_strip(2000);
    mesh.positions[777] = mesh.positions[777] + Vec3d{0, 0, 1e-9};
    EXPECT_FALSE(flat_needle_map(mesh.positions, mesh.faces));
}

TEST(FlatNeedleMap, RefusesWhatTurnsOver) {
    TriMesh mesh = tilted_strip(2000);
    std::swap(mesh.faces[5][0], mesh.faces[5][1]);
    EXPECT_FALSE(flat_needle_map(mesh.positions, mesh.faces));
}

TEST(FlatNeedleMap, RefusesNothingness) {
    EXPECT_FALSE(flat_needle_map({}, {}));
    const std::vector<Vec3d> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    const std::vector<Face> faces{{0, 1, 2}};
    EXPECT_FALSE(flat_needle_map(line, faces));
}

}  // namespace
}  // namespace dgm::bake
