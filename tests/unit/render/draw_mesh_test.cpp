// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/draw_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "charts.h"
#include "geometry/metrics/reconstruction.h"

namespace dgm::render {
namespace {

TEST(DrawMesh, ThinSheetsKeepBothSides) {
    // Two sheets closer than any lattice cell, one up, one down.
    const bake::Reconstruction sheet = bake::reconstruct(hill(65, 65));
    model::TriMesh mesh = sheet.mesh;
    mesh.corner_uvs.clear();
    for (const model::Vec3d& p : sheet.mesh.positions) mesh.positions.push_back(p - model::Vec3d{0, 0, 1e-6});
    for (const model::Face& f : sheet.mesh.faces) mesh.faces.push_back({f[0] + 4225, f[2] + 4225, f[1] + 4225});
    const DrawMesh drawn = draw_mesh(mesh, 1500);
    EXPECT_TRUE(drawn.simplified);
    EXPECT_LE(drawn.positions.size(), 1500U);
    EXPECT_GT(drawn.positions.size(), 400U);
    const auto up = std::count_if(drawn.normals.begin(), drawn.normals.end(), [](const auto& n) { return n.z > 0.3; });
    const auto down =
        std::count_if(drawn.normals.begin(), drawn.normals.end(), [](const auto& n) { return n.z < -0.3; });
    EXPECT_EQ(static_cast<std::size_t>(up + down), drawn.normals.size());
    EXPECT_GT(down, 200);
}

TEST(DrawMesh, BrokenFacesAreLeftOut) {
    model::TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, NAN, 0}};
    mesh.faces = {{0, 1, 2}, {0, 1, 3}};
    EXPECT_EQ(draw_mesh(mesh, 100).faces.size(), 1U);
}

}  // namespace
}  // namespace dgm::render
