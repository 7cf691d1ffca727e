// SPDX-License-Identifier: GPL-3.0-or-later
// tests/property/repair_test.cpp
// Any heap of triangles becomes oriented manifolds that open into disks, or is refused for a reason.
#include "geometry/repair/repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <string>
#include <utility>

#include "geometry/cut/cut_graph.h"
#include "geometry/metrics/map_metrics.h"
#include "model/codes.h"
#include "support/disk_checks.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

void expect_sound(const RepairedMesh& repaired) {
    for (const TriMesh& mesh : repaired.components) {
        const Topology t = measure_topology(mesh.positions.size(), mesh.faces);
        ASSERT_TRUE(t.manifold);
        ASSERT_TRUE(t.oriented);
        ASSERT_EQ(t.components, 1u);
        ASSERT_EQ(t.degenerate_faces, 0u);
        std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
        std::vector<char> used(mesh.positions.size(), 0);
        for (const Face& f : mesh.faces)
            for (int k = 0; k < 3; ++k) {
                ASSERT_EQ((++directed[{f[k], f[(k + 1) % 3]}]), 1) << "two edges between the same two vertices";
                used[f[k]] = 1;
            }
        ASSERT_EQ(std::count(used.begin(), used.end(), 0), 0);
        CutGraph cut(mesh);
        cut.cut_to_disk();
        const Disk disk = cut.open();
        ASSERT_NO_FATAL_FAILURE(test::expect_links(disk));
        ASSERT_NO_FATAL_FAILURE(test::expect_disk(disk));
    }
}

/// A disk of an opened surface, joined again, is the surface that the source was.
void expect_joined(const TriMesh& component) {
    CutGraph cut(component);
    cut.cut_to_disk();
    Disk disk = cut.open();
    disk.join_sides();
    const std::vector<std::uint8_t> reversed = disk.reversed_vertices();
    ASSERT_EQ(reversed.size(), disk.weld.size());
    std::size_t against = 0;
    for (std::uint32_t h = 0; h < disk.mate.size(); ++h) {
        const std::uint32_t g = disk.mate[h];
        if (g == kNone) continue;
        ASSERT_EQ(disk.mate[g], h);
        const bool same = disk.same_way(h);
        against += same;
        const std::uint32_t a = origin(disk.mesh.faces, h), b = target(disk.mesh.faces, h);
        const std::uint32_t c = origin(disk.mesh.faces, g), d = target(disk.mesh.faces, g);
        ASSERT_EQ(disk.weld[a], disk.weld[same ? c : d]);
        ASSERT_EQ(disk.weld[b], disk.weld[same ? d : c]);
        ASSERT_EQ(reversed[a] != reversed[same ? c : d], same);
        ASSERT_EQ(reversed[b] != reversed[same ? d : c], same);
        ASSERT_EQ(disk.mesh.positions[a], disk.mesh.positions[same ? c : d]);
    }
    ASSERT_GT(against, 0u);
    std::size_t first = 0;
    for (const BorderPath& path : disk.paths()) {
        if (path.mate != kNone) {
            ASSERT_EQ(disk.paths()[path.mate].half_edges.size(), path.half_edges.size());
            ASSERT_NE(path.mate, first);
        }
        ++first;
    }
    std::vector<Face> welded = disk.mesh.faces;
    for (Face& f : welded)
        for (std::uint32_t& v : f) v = disk.weld[v];
    ASSERT_EQ(measure_topology(disk.weld_count, welded), measure_topology(component));
}

/// Few vertices and many faces: every kind of bad edge and vertex there is.
TEST(Repair, AnyHeapOfTrianglesBecomesManifoldsOrIsRefused) {
    std::mt19937 random(21);
    int sound = 0, one_sided = 0;
    for (int round = 0; round < 3000; ++round) {
        TriMesh mesh;
        const std::uint32_t vertices = 4 + random() % 9, faces = 1 + random() % 24;
        for (std::uint32_t v = 0; v < vertices; ++v)  // on a coarse lattice: coincident and collinear ones, too
            mesh.positions.push_back({double(random() % 3), double(random() % 3), double(random() % 3)});
        for (std::uint32_t f = 0; f < faces; ++f)
            mesh.faces.push_back({static_cast<std::uint32_t>(random() % vertices),
                                  static_cast<std::uint32_t>(random() % vertices),
                                  static_cast<std::uint32_t>(random() % vertices)});
        test::paint_positions(mesh);
        SCOPED_TRACE("round " + std::to_string(round));
        try {
            const RepairedMesh out = repair(mesh);
            ASSERT_NO_FATAL_FAILURE(expect_sound(out));
            for (const TriMesh& component : out.components)
                for (std::size_t f = 0; f < component.faces.size(); ++f)
                    for (int k = 0; k < 3; ++k) {
                        const Vec3d p =
                            out.frame.centre + component.positions[component.faces[f][k]] * out.frame.diagonal;
                        ASSERT_LT(length(component.corner_uvs[3 * f + k] - Vec2d{p.x, p.y}), 1e-9);
                    }
            for (const TriMesh& component : out.components) {
                if (component.points.empty()) continue;
                ++one_sided;
                ASSERT_NO_FATAL_FAILURE(expect_joined(component));
            }
            ++sound;
        } catch (const model::Error& e) { ASSERT_EQ(e.code().number, model::codes::kNoFaces.number) << e.what(); }
    }
    EXPECT_GT(sound, 1000);
    EXPECT_GT(one_sided, 10);
}

}  // namespace
}  // namespace dgm::bake
