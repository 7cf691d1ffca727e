// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/parameterize/multilevel_map_test.cpp
// A map refined from a coarse one is one to one, keeps its border and is as good as the one solved at full size.
#include "geometry/parameterize/multilevel_map.h"

#include <gtest/gtest.h>

#include "geometry/parameterize/convex_map.h"
#include "geometry/parameterize/slim.h"
#include "laid_disk.h"
#include "support/dice.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

TEST(MultilevelMap, IsOneToOneAndNoWorseThanTheSolveAtFullSize) {
    for (const TriMesh& mesh : {test::icosphere(5), test::torus(1, 0.4, 120, 60), test::finger(0.2, 1, 60, 60, 20)}) {
        const test::LaidDisk laid = test::lay(mesh, 65, 3);
        const DiskView view = laid.view();
        MultilevelOptions options;
        options.power = 1;  // what the full solve minimises
        const auto uv = multilevel_stretch_map(view, options, {});
        ASSERT_TRUE(uv);
        EXPECT_EQ(count_not_positive(view.faces, *uv), 0u);
        for (std::size_t k = 0; k < laid.border.vertices.size(); ++k)
            ASSERT_EQ((*uv)[laid.border.vertices[k]], laid.border.uv[k]);
        SlimOptions newton;
        newton.energy = FlipFreeEnergy::kStretch;
        newton.border_fixed = true;
        newton.iterations = 8;
        const std::vector<Vec2d> full = descend_flip_free(view, reweighted_stretch_map(view, {}, {}), newton, {});
        EXPECT_LT(stretch_energy(view.positions, view.faces, *uv),
                  1.03 * stretch_energy(view.positions, view.faces, full));
    }
}

/// A ball whose vertices lie up to `share` of an edge beside their places.
TriMesh rough_ball(int level, double share) {
    TriMesh ball = test::icosphere(level);
    const double edge = 1.1 / (1 << level);
    test::Dice dice(std::uint64_t{7});
    for (Vec3d& p : ball.positions)
        for (int k = 0; k < 3; ++k) p[k] += share * edge * static_cast<double>(dice.real(-1, 1));
    return ball;
}

TEST(MultilevelMap, OfManyFacesStretchesNoneFarMoreThanOfFew) {
    // The square of the stretch is what single faces decide: put back and left alone, as most of so many are, slivers
    // among them come to 900 times the square for all.
    const test::LaidDisk few = test::lay(rough_ball(5, 0.6), 65, 3), many = test::lay(rough_ball(7, 0.6), 65, 3);
    const auto energy = [](const test::LaidDisk& of) {
        const auto uv = multilevel_stretch_map(of.view(), {}, {});
        EXPECT_TRUE(uv);
        return stretch_energy(of.disk.mesh.positions, of.disk.mesh.faces, *uv);
    };
    EXPECT_LT(energy(many), 1.3 * energy(few));
}

TEST(MultilevelMap, AFlatSquareIsLeftFlat) {
    // The identity has the least stretch of all maps of the unit square onto itself: 1 everywhere.
    const test::LaidDisk laid = test::lay(test::grid_sheet(60, 60), 65, 0);
    const auto uv = multilevel_stretch_map(laid.view(), {}, {});
    ASSERT_TRUE(uv);
    EXPECT_NEAR(stretch_energy(laid.disk.mesh.positions, laid.disk.mesh.faces, *uv), 1, 1e-3);
}

TEST(MultilevelMap, AMemoryChangesNoMap) {
    const test::LaidDisk laid = test::lay(test::icosphere(5), 65, 3);
    MultilevelOptions finished;
    finished.finish_faces = laid.view().faces.size() / 2;
    finished.finish = [](const DiskView& level, std::vector<Vec2d> uv) {
        SlimOptions options;
        options.energy = FlipFreeEnergy::kStretch;
        options.border_fixed = true;
        options.iterations = 2;
        return descend_flip_free(level, std::move(uv), options, {});
    };
    MultilevelOptions plain;
    plain.finish_faces = finished.finish_faces;
    const auto with = multilevel_stretch_map(laid.view(), finished, {}),
               without = multilevel_stretch_map(laid.view(), {}, {});
    ASSERT_TRUE(with && without);
    EXPECT_NE(*with, *without);
    MultilevelMemory memory;
    for (int time = 0; time < 2; ++time) {
        EXPECT_EQ(multilevel_stretch_map(laid.view(), finished, {}, &memory), with);
        EXPECT_EQ(multilevel_stretch_map(laid.view(), plain, {}, &memory), without);
    }
    const test::LaidDisk turned = test::lay(test::icosphere(5), 65, 9);  // the same disk with another border
    EXPECT_EQ(multilevel_stretch_map(turned.view(), plain, {}, &memory),
              multilevel_stretch_map(turned.view(), plain, {}));
}

TEST(MultilevelMap, TheFinestSmallEnoughLevelIsFinishedOnce) {
    const test::LaidDisk laid = test::lay(test::icosphere(5), 65, 3);
    MultilevelOptions options;
    options.finish_faces = laid.view().faces.size() / 2;
    int calls = 0;
    options.finish = [&](const DiskView& level, std::vector<Vec2d> uv) {
        ++calls;
        EXPECT_LE(level.faces.size(), options.finish_faces);
        EXPECT_GT(level.faces.size(), options.finish_faces / 8);
        EXPECT_EQ(level.border.size(), laid.border.vertices.size());
        for (std::size_t k = 0; k < level.border.size(); ++k) {
            EXPECT_EQ(uv[level.border[k]], laid.border.uv[k]);
            EXPECT_EQ(level.positions[level.border[k]], laid.disk.mesh.positions[laid.border.vertices[k]]);
        }
        EXPECT_EQ(count_not_positive(level.faces, uv), 0u);
        return uv;
    };
    const auto uv = multilevel_stretch_map(laid.view(), options, {});
    ASSERT_TRUE(uv);
    EXPECT_EQ(calls, 1);
    EXPECT_EQ(count_not_positive(laid.view().faces, *uv), 0u);
}

TEST(MultilevelMap, TheBorderStaysWhereTheCoarsestMapPutsIt) {
    const test::LaidDisk laid = test::lay(test::icosphere(5), 65, 3);
    MultilevelOptions options;
    options.map_coarsest = [](const DiskView& level) -> std::optional<std::vector<Vec2d>> {
        std::vector<Vec2d> twice;
        for (const Vec2d& p : level.border_uv) twice.push_back(p * 2);
        ConvexMapSolver solver(level.positions.size(), level.faces, level.border);
        return solver.solve(positive_cotangent_weights(level.positions, level.faces, solver.edges()), twice);
    };
    const auto uv = multilevel_stretch_map(laid.view(), options, {});
    ASSERT_TRUE(uv);
    EXPECT_EQ(count_not_positive(laid.view().faces, *uv), 0u);
    for (std::size_t k = 0; k < laid.border.vertices.size(); ++k)
        EXPECT_EQ((*uv)[laid.border.vertices[k]], laid.border.uv[k] * 2);
    options.map_coarsest = [](const DiskView&) { return std::nullopt; };
    EXPECT_FALSE(multilevel_stretch_map(laid.view(), options, {}));
}

TEST(MultilevelMap, SameInputSameMap) {
    const test::LaidDisk laid = test::lay(test::icosphere(5), 65, 3);
    const auto a = multilevel_stretch_map(laid.view(), {}, {}), b = multilevel_stretch_map(laid.view(), {}, {});
    ASSERT_TRUE(a && b);
    EXPECT_EQ(*a, *b);
}

}  // namespace
}  // namespace dgm::bake
