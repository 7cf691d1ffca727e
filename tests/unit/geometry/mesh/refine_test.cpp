// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/mesh/refine_test.cpp
// A refined mesh is the same surface with more faces.
#include "geometry/mesh/refine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/metrics/map_metrics.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

double longest_edge(const TriMesh& mesh) {
    double squared = 0;
    for (const Face& f : mesh.faces)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d along = mesh.positions[f[(k + 1) % 3]] - mesh.positions[f[k]];
            squared = std::max(squared, dot(along, along));
        }
    return std::sqrt(squared);
}

TEST(Refine, KeepsTheSurfaceAndItsTopology) {
    for (const TriMesh& mesh : {test::icosphere(0), test::genus_plate(2, 1), test::annulus(1, 2, 12, 1)}) {
        const TriMesh fine = refine(mesh, 3000);
        EXPECT_GE(fine.faces.size(), 3000U);
        EXPECT_LE(fine.faces.size(), 3001U);
        EXPECT_NEAR(test::surface_area(fine), test::surface_area(mesh), 1e-9);
        EXPECT_NEAR(test::volume(fine), test::volume(mesh), 1e-9);
        const Topology before = measure_topology(mesh.positions.size(), mesh.faces);
        const Topology after = measure_topology(fine.positions.size(), fine.faces);
        EXPECT_TRUE(after.manifold && after.oriented);
        EXPECT_EQ(after.genus, before.genus);
        EXPECT_EQ(after.boundary_loops, before.boundary_loops);
    }
}

/// 3000 equilateral triangles of the icosahedron's area have edges of its own over the root of 150; halving leaves none
/// twice as long.
TEST(Refine, HalvesTheLongestEdgesFirst) {
    const TriMesh mesh = test::icosphere(0);
    EXPECT_LT(longest_edge(refine(mesh, 3000)), 2 * longest_edge(mesh) / std::sqrt(150));
}

TEST(Refine, InterpolatesCorners) {
    TriMesh square;
    square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    square.faces = {{0, 1, 2}, {0, 2, 3}};
    for (const Face& f : square.faces)
        for (const std::uint32_t v : f) square.corner_uvs.push_back({square.positions[v].x, square.positions[v].y});
    const TriMesh fine = refine(square, 500);
    ASSERT_EQ(fine.corner_uvs.size(), 3 * fine.faces.size());
    for (std::size_t c = 0; c < fine.corner_uvs.size(); ++c) {
        const Vec3d& at = fine.positions[fine.faces[c / 3][c % 3]];
        EXPECT_NEAR(fine.corner_uvs[c].x, at.x, 1e-12);
        EXPECT_NEAR(fine.corner_uvs[c].y, at.y, 1e-12);
    }
}

TEST(Refine, LeavesWhatIsFineEnough) {
    const TriMesh ball = test::icosphere(2);
    EXPECT_EQ(refine(ball, ball.faces.size()).faces, ball.faces);
}

}  // namespace
}  // namespace dgm::bake
