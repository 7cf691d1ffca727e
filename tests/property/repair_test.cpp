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
            ++sound;
        } catch (const model::Error& e) {
            const int code = e.code().number;
            ASSERT_TRUE(code == model::codes::kNonOrientable.number || code == model::codes::kNoFaces.number)
                << e.what();
            one_sided += code == model::codes::kNonOrientable.number;
        }
    }
    EXPECT_GT(sound, 1000);
    EXPECT_GT(one_sided, 10);
}

}  // namespace
}  // namespace dgm::bake
