// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/mesh/refine_test.cpp
// A refined mesh is the same surface with more faces.
#include "geometry/mesh/refine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
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

double least_angle(const TriMesh& mesh) {
    double least = M_PI;
    for (const Face& f : mesh.faces)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d& at = mesh.positions[f[k]];
            const Vec3d a = mesh.positions[f[(k + 1) % 3]] - at, b = mesh.positions[f[(k + 2) % 3]] - at;
            least = std::min(least, std::atan2(length(cross(a, b)), dot(a, b)));
        }
    return least;
}

/// A fan from one corner of a polygon of 60 has angles of 3 degrees there; so few on its own edges alone cannot be cut
/// out of it.
TEST(Refine, NeedlesOnPlanesGo) {
    TriMesh polygon;
    for (int k = 0; k < 60; ++k) polygon.positions.push_back({std::cos(k * M_PI / 30), std::sin(k * M_PI / 30), 0.5});
    for (std::uint32_t k = 1; k + 1 < 60; ++k) polygon.faces.push_back({0, k, k + 1});
    ASSERT_LT(least_angle(polygon), 3.01 * M_PI / 180);
    const TriMesh fine = refine(polygon, 3000);
    EXPECT_GT(least_angle(fine), 20 * M_PI / 180);
    EXPECT_NEAR(test::surface_area(fine), 30 * std::sin(M_PI / 30), 1e-12);
    EXPECT_EQ(measure_topology(fine.positions.size(), fine.faces).boundary_loops, 1U);
}

/// Two halves of a strip, each with texture coordinates of its own, or each of one of two materials.
TEST(Refine, FlipsKeepToSeams) {
    TriMesh strip;
    strip.positions = {{0, 0, 0}, {8, 0, 0}, {9, 1, 0}, {1, 1, 0}};
    strip.faces = {{0, 1, 2}, {0, 2, 3}};
    const auto below = [](const Vec3d& at) { return at.y < at.x / 9; };
    TriMesh seam = strip;
    for (std::uint32_t c = 0; c < 6; ++c) {
        const Vec3d& at = strip.positions[strip.faces[c / 3][c % 3]];
        seam.corner_uvs.push_back({c < 3 ? at.x : at.x + 20, at.y});
    }
    const TriMesh fine = refine(seam, 400);
    for (std::size_t f = 0; f < fine.faces.size(); ++f) {
        const std::array<Vec3d, 3> corners = fine.corners(f);
        const double shift = below((corners[0] + corners[1] + corners[2]) / 3) ? 0 : 20;
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(fine.corner_uvs[3 * f + k].x, corners[k].x + shift, 1e-9);
    }
    TriMesh painted = strip;
    painted.face_materials = {0, 1};
    const TriMesh fine_paint = refine(painted, 400);
    for (std::size_t f = 0; f < fine_paint.faces.size(); ++f) {
        const std::array<Vec3d, 3> corners = fine_paint.corners(f);
        EXPECT_EQ(fine_paint.face_materials[f], below((corners[0] + corners[1] + corners[2]) / 3) ? 0U : 1U);
    }
    EXPECT_GT(least_angle(refine(strip, 400)), 20 * M_PI / 180);
    EXPECT_LT(least_angle(fine), 7 * M_PI / 180) << "the corner between the seam and the border stays";
}

/// Texture coordinates by angle are nearly linear from each narrow facet to the next, all around to the seam's other
/// side.
TEST(Refine, FlipsKeepToSeamsThatFacetsLeadAround) {
    TriMesh ring = test::annulus(0.4, 2, 600, 1);
    for (std::size_t f = 0; f < ring.faces.size(); ++f) {
        const std::array<Vec3d, 3> corners = ring.corners(f);
        const Vec3d middle = (corners[0] + corners[1] + corners[2]) / 3;
        for (const Vec3d& at : corners) {
            const double angle = std::atan2(at.y, at.x);  // -pi and pi are the seam
            const bool beyond = std::abs(angle) > 3.14159 && angle * middle.y < 0;
            ring.corner_uvs.push_back({(beyond ? -angle : angle) / (2 * M_PI), std::hypot(at.x, at.y)});
        }
    }
    const auto seam_length = [](const TriMesh& mesh) {
        double sum = 0;
        const std::vector<std::uint32_t> opposite = opposite_half_edges(mesh.faces);
        for (std::uint32_t h = 0; h < opposite.size(); ++h) {
            if (opposite[h] == kNone || opposite[h] < h) continue;
            const double jump = mesh.corner_uvs[h].x - mesh.corner_uvs[next_half_edge(opposite[h])].x;
            const Vec3d along = mesh.positions[target(mesh.faces, h)] - mesh.positions[origin(mesh.faces, h)];
            if (std::abs(jump) > 0.5) sum += length(along);
        }
        return sum;
    };
    ASSERT_NEAR(seam_length(ring), 1.6, 1e-6);
    EXPECT_NEAR(seam_length(refine(ring, 6000)), 1.6, 1e-6);
}

TEST(Refine, LeavesWhatIsFineEnough) {
    const TriMesh ball = test::icosphere(2);
    EXPECT_EQ(refine(ball, ball.faces.size()).faces, ball.faces);
}

}  // namespace
}  // namespace dgm::bake
