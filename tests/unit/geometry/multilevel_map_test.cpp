// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/multilevel_map_test.cpp
// A map refined from a coarse one is one to one, keeps its border and is as good as the one solved at full size.
#include "geometry/parameterize/multilevel_map.h"

#include <gtest/gtest.h>

#include "geometry/parameterize/convex_map.h"
#include "geometry/parameterize/slim.h"
#include "laid_disk.h"
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

TEST(MultilevelMap, AFlatSquareIsLeftFlat) {
    // The identity has the least stretch of all maps of the unit square onto itself: 1 everywhere.
    const test::LaidDisk laid = test::lay(test::grid_sheet(60, 60), 65, 0);
    const auto uv = multilevel_stretch_map(laid.view(), {}, {});
    ASSERT_TRUE(uv);
    EXPECT_NEAR(stretch_energy(laid.disk.mesh.positions, laid.disk.mesh.faces, *uv), 1, 1e-3);
}

TEST(MultilevelMap, SameInputSameMap) {
    const test::LaidDisk laid = test::lay(test::icosphere(5), 65, 3);
    const auto a = multilevel_stretch_map(laid.view(), {}, {}), b = multilevel_stretch_map(laid.view(), {}, {});
    ASSERT_TRUE(a && b);
    EXPECT_EQ(*a, *b);
}

}  // namespace
}  // namespace dgm::bake
