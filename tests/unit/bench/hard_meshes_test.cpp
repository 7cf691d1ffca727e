// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/hard_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/metrics/map_metrics.h"

namespace dgm::bench {
namespace {

using model::TriMesh;

double six_volume(const TriMesh& mesh) {
    double sum = 0;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const auto q = mesh.corners(f);
        sum += dot(q[0], cross(q[1], q[2]));
    }
    return sum;
}

void expect_shape(const TriMesh& mesh, std::uint64_t loops, std::int64_t genus) {
    const bake::Topology t = bake::measure_topology(mesh.positions.size(), mesh.faces);
    EXPECT_TRUE(t.manifold && t.oriented);
    EXPECT_EQ(t.components, 1U);
    EXPECT_EQ(t.boundary_loops, loops);
    EXPECT_EQ(t.genus, genus);
    EXPECT_EQ(t.degenerate_faces, 0U);
}

TEST(HardMeshes, HaveTheTopologyTheySay) {
    expect_shape(dome(), 1, 0);
    expect_shape(fan_cone(1000), 1, 0);
    expect_shape(tube(10), 2, 0);
    for (const std::uint32_t holes : {0U, 1U, 5U}) expect_shape(pierced_slab(holes), 0, holes);
    expect_shape(bumpy_ball(5000), 0, 0);
}

TEST(HardMeshes, ClosedOnesFaceOutward) {
    EXPECT_GT(six_volume(bumpy_ball(2000)), 0);
    // A slab of 3 x 3 cubes with one hole: eight cubes.
    EXPECT_NEAR(six_volume(pierced_slab(1)), 6 * 8, 1e-9);
}

TEST(HardMeshes, AreAsHardAsAsked) {
    EXPECT_NEAR(static_cast<double>(bumpy_ball(100'000).faces.size()), 100'000, 2000);
    const TriMesh sliver = sliver_dome(1e-6);
    double least = 1;
    for (std::size_t f = 0; f < sliver.faces.size(); ++f) {
        const auto q = sliver.corners(f);
        least = std::min(least, std::fabs(q[1].x - q[0].x) + std::fabs(q[2].x - q[0].x));
    }
    EXPECT_NEAR(least, 2 * 1e-6 / 16, 1e-6 / 16 * 1.01);
    const TriMesh graded = graded_dome(1e4);
    const double first = graded.positions[17].x - graded.positions[0].x;
    const double last = graded.positions[17 * 16].x - graded.positions[17 * 15].x;
    EXPECT_NEAR(first / last, 1e4, 1);
    EXPECT_EQ(fan_cone(777).faces.size(), 777U * 5);
}

}  // namespace
}  // namespace dgm::bench
