// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/mesh/split_edge_test.cpp
// Vertices put into edges: links, area and attributes after one split and after many.
#include "geometry/mesh/split_edge.h"

#include <gtest/gtest.h>

#include <random>

#include "geometry/cut/cut_graph.h"
#include "geometry/metrics/map_metrics.h"
#include "support/disk_checks.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

TEST(SplitEdge, OneTriangleByHand) {
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
    mesh.faces = {{0, 1, 2}};
    mesh.corner_uvs = {{0, 0}, {8, 4}, {0, 1}};
    mesh.corner_normals = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
    mesh.corner_colours = {{0, 100, 0, 255}, {200, 20, 0, 55}, {9, 9, 9, 9}};
    mesh.face_materials = {3};
    std::vector<std::uint32_t> opposite(3, kNone);
    const NewVertices added = split_edge(mesh, opposite, 0, 0.25);
    EXPECT_EQ(added.vertex, 3u);
    EXPECT_EQ(added.twin, kNone);
    EXPECT_EQ(mesh.positions[3], (Vec3d{1, 0, 0}));
    ASSERT_EQ(mesh.faces.size(), 2u);
    EXPECT_EQ(mesh.faces[0], (Face{0, 3, 2}));
    EXPECT_EQ(mesh.faces[1], (Face{3, 1, 2}));
    EXPECT_EQ(mesh.face_materials, (std::vector<std::uint32_t>{3, 3}));
    EXPECT_EQ(mesh.corner_uvs, (std::vector<Vec2d>{{0, 0}, {2, 1}, {0, 1}, {2, 1}, {8, 4}, {0, 1}}));
    EXPECT_EQ(mesh.corner_colours[1], (model::Rgba8{50, 80, 0, 205}));
    EXPECT_EQ(mesh.corner_colours[3], (model::Rgba8{50, 80, 0, 205}));
    EXPECT_EQ(mesh.corner_colours[4], (model::Rgba8{200, 20, 0, 55}));
    EXPECT_NEAR(length(mesh.corner_normals[1] - Vec3d{1, 0, 3} / std::sqrt(10.0)), 0, 1e-15);
    EXPECT_EQ(mesh.corner_normals[1], mesh.corner_normals[3]);
    EXPECT_EQ(opposite, (std::vector<std::uint32_t>{kNone, 5, kNone, kNone, kNone, 1}));
    EXPECT_EQ(origin(mesh.faces, added.first), 0u);
    EXPECT_EQ(target(mesh.faces, added.first), 3u);
}

/// Links must be those that a fresh search finds, whatever edges were split in whatever order.
TEST(SplitEdge, ManySplitsOfAClosedSurfaceKeepTheLinks) {
    std::mt19937 random(1);
    TriMesh mesh = test::icosphere(1);
    test::paint_positions(mesh);
    const double area = test::surface_area(mesh);
    std::vector<std::uint32_t> opposite = opposite_half_edges(mesh.faces);
    for (int k = 0; k < 300; ++k) {
        const auto h = static_cast<std::uint32_t>(random() % opposite.size());
        const std::uint32_t a = origin(mesh.faces, h), b = target(mesh.faces, h);
        const double t = 0.2 + 0.6 * static_cast<double>(random()) / 4294967296.0;
        const Vec3d want = mesh.positions[a] * (1 - t) + mesh.positions[b] * t;
        const NewVertices added = split_edge(mesh, opposite, h, t);
        ASSERT_LT(length(mesh.positions[added.vertex] - want), 1e-15);
        ASSERT_EQ(origin(mesh.faces, added.first), a);
        ASSERT_EQ(target(mesh.faces, added.first), added.vertex);
    }
    EXPECT_EQ(mesh.positions.size(), 42u + 300u);
    EXPECT_EQ(mesh.faces.size(), 80u + 600u);
    EXPECT_EQ(opposite, opposite_half_edges(mesh.faces));
    EXPECT_EQ(measure_topology(mesh.positions.size(), mesh.faces), (Topology{1, 0, 0, true, true, 0}));
    EXPECT_NEAR(test::surface_area(mesh), area, 1e-12 * area);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        for (int k = 0; k < 3; ++k) {
            const Vec3d p = mesh.positions[mesh.faces[f][k]];
            ASSERT_LT(length(mesh.corner_uvs[3 * f + k] - Vec2d{p.x, p.y}), 1e-14);
        }
}

TEST(SplitEdge, ManySplitsOfAnOpenedSurfaceKeepMatesAndWelds) {
    std::mt19937 random(2);
    for (const TriMesh& mesh :
         {test::torus(1, 0.4, 9, 6), test::icosphere(0), test::annulus(1, 2, 7, 2), test::genus_plate(2)}) {
        CutGraph cut(mesh);
        cut.cut_to_disk();
        Disk disk = cut.open();
        test::paint_positions(disk.mesh);
        const double area = test::surface_area(disk.mesh);
        for (int k = 0; k < 200; ++k) {
            const auto h = static_cast<std::uint32_t>(random() % disk.opposite.size());
            const bool mated = disk.mate[h] != kNone;
            const std::uint32_t a = origin(disk.mesh.faces, h);
            const NewVertices added = disk.split(h, 0.25 + 0.125 * static_cast<double>(random() % 5));
            ASSERT_EQ(added.twin != kNone, mated);
            if (mated) {
                ASSERT_EQ(disk.weld[added.twin], disk.weld[added.vertex]);
                ASSERT_EQ(disk.mesh.positions[added.twin], disk.mesh.positions[added.vertex]);
            }
            ASSERT_EQ(origin(disk.mesh.faces, added.first), a);
            ASSERT_EQ(target(disk.mesh.faces, added.first), added.vertex);
            ASSERT_NO_FATAL_FAILURE(test::expect_links(disk)) << "split " << k;
        }
        test::expect_disk(disk);
        EXPECT_NEAR(test::surface_area(disk.mesh), area, 1e-12 * area);
        for (std::size_t f = 0; f < disk.mesh.faces.size(); ++f)
            for (int k = 0; k < 3; ++k) {
                const Vec3d p = disk.mesh.positions[disk.mesh.faces[f][k]];
                ASSERT_LT(length(disk.mesh.corner_uvs[3 * f + k] - Vec2d{p.x, p.y}), 1e-14);
            }
    }
}

/// A cone of one face: its two straight edges are the two sides of one cut, both in that face.
TEST(SplitEdge, BothSidesOfACutInOneFace) {
    for (std::uint32_t h : {0u, 1u}) {
        Disk disk;
        disk.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}};
        disk.mesh.faces = {{0, 1, 2}};
        disk.weld = {0, 1, 0};
        disk.weld_count = 2;
        disk.opposite.assign(3, kNone);
        disk.mate = {1, 0, kNone};
        const NewVertices added = disk.split(h, 0.25);
        ASSERT_NE(added.twin, kNone);
        EXPECT_EQ(disk.mesh.positions.size(), 5u);
        EXPECT_EQ(disk.mesh.faces.size(), 3u);
        EXPECT_EQ(disk.mesh.positions[added.vertex], (Vec3d{h == 0 ? 0.25 : 0.75, 0, 0}));
        EXPECT_EQ(origin(disk.mesh.faces, added.first), h);
        EXPECT_EQ(target(disk.mesh.faces, added.first), added.vertex);
        test::expect_links(disk);
        test::expect_disk(disk);
        EXPECT_EQ(disk.border().size(), 5u);
    }
}

/// Two triangles glued along all three edges, but with one pair of them standing between the same two vertices.
TEST(SplitEdge, RepeatedEdgesGetAVertexInTheMiddle) {
    // Two discs 0-1-2 and 0-1-3 either side of two edges 0-1: (0,1,2), (1,0,3) joined by one, (0,1,3'), (1,0,2') by the
    // other.
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, -1, 0}};
    mesh.faces = {{0, 1, 2}, {1, 0, 3}, {0, 1, 3}, {1, 0, 2}};
    // Half-edges 0-1: 0 (face 0), 3 (face 1), 6 (face 2), 9 (face 3). Glue 0 with 3, 6 with 9; the rest by their ends.
    std::vector<std::uint32_t> partner(12, kNone);
    const auto glue = [&](std::uint32_t a, std::uint32_t b) {
        partner[a] = b;
        partner[b] = a;
    };
    glue(0, 3);
    glue(6, 9);
    glue(1, 11);  // 1-2 with 2-1, 2-0 with 0-2
    glue(2, 10);
    glue(4, 8);  // 0-3 with 3-0, 3-1 with 1-3
    glue(5, 7);
    EXPECT_EQ(split_repeated_edges(mesh, partner), 1u);
    EXPECT_EQ(measure_topology(mesh.positions.size(), mesh.faces), (Topology{1, 0, 0, true, true, 0}));
    EXPECT_EQ(mesh.positions.size(), 5u);
    EXPECT_EQ(mesh.positions[4], (Vec3d{0.5, 0, 0}));
    EXPECT_EQ(opposite_half_edges(mesh.faces), partner);
}

}  // namespace
}  // namespace dgm::bake
