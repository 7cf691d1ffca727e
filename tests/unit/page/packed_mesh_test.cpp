// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/page/packed_mesh_test.cpp
#include "page/packed_mesh.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dgm::page {
namespace {

int byte_at(const PackedMesh& mesh, std::size_t k) {
    return std::to_integer<int>(mesh.bytes[k]);
}

TEST(PackedMesh, IsDifferencesInPlanes) {
    const model::Vec3d points[] = {{10, 0, 0}, {10 + 65535, 0, 0}, {11, 300, 0}};
    const model::Face faces[] = {{0, 2, 1}};
    const PackedMesh mesh = packed_mesh(points, faces);
    EXPECT_EQ(mesh.low.x, 10);
    EXPECT_EQ(mesh.step, 1);
    ASSERT_EQ(mesh.bytes.size(), 3U * 3 * 2 + 3 * 4);
    // x: 0, then 65535 = -1, then 1 - 65535 = 2: with the sign lowest 0, 1, 4.
    // y of the last: 300, thus 600 = 2 * 256 + 88.
    EXPECT_EQ(byte_at(mesh, 0), 0);
    EXPECT_EQ(byte_at(mesh, 3), 1);
    EXPECT_EQ(byte_at(mesh, 6), 4);
    EXPECT_EQ(byte_at(mesh, 7), 88);
    EXPECT_EQ(byte_at(mesh, 9 + 7), 2);
    // Indices 0, 2, 1: differences 0, 2, -1.
    EXPECT_EQ(byte_at(mesh, 18), 0);
    EXPECT_EQ(byte_at(mesh, 19), 4);
    EXPECT_EQ(byte_at(mesh, 20), 1);
    for (std::size_t k = 21; k < 30; ++k) EXPECT_EQ(byte_at(mesh, k), 0);
}

TEST(PackedMesh, TakesWhatIsNotFiniteAndWhatHasNoSize) {
    const model::Vec3d odd[] = {{NAN, 0, 0}, {1, 2, 3}};
    const PackedMesh mesh = packed_mesh(odd, {});
    EXPECT_EQ(mesh.low.y, 2);
    EXPECT_EQ(mesh.step, 1);
    EXPECT_EQ(packed_mesh({}, {}).bytes.size(), 0U);
}

}  // namespace
}  // namespace dgm::page
