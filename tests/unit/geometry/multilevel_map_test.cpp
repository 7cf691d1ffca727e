// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/multilevel_map_test.cpp
// A map refined from a coarse one is one to one, keeps its border and is as good as the one solved at full size.
#include "geometry/parameterize/multilevel_map.h"

#include <gtest/gtest.h>

#include "geometry/cut/cut_graph.h"
#include "geometry/parameterize/convex_map.h"
#include "geometry/parameterize/slim.h"
#include "geometry/parameterize/square_border.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

struct Laid {
    Disk disk;
    SquareBorder border;
    [[nodiscard]] DiskView view() const { return {disk.mesh.positions, disk.mesh.faces, border.vertices, border.uv}; }
};
Laid lay(const TriMesh& mesh, std::uint32_t rotation = 3) {
    CutGraph cut(mesh);
    cut.cut_to_disk();
    Laid out{cut.open(), {}};
    out.border = lay_square_border(out.disk, 65, 65, rotation);
    return out;
}

TEST(MultilevelMap, IsOneToOneAndNoWorseThanTheSolveAtFullSize) {
    for (const TriMesh& mesh : {test::icosphere(5), test::torus(1, 0.4, 120, 60), test::finger(0.2, 1, 60, 60, 20)}) {
        const Laid laid = lay(mesh);
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
    const Laid laid = lay(test::grid_sheet(60, 60), 0);
    const auto uv = multilevel_stretch_map(laid.view(), {}, {});
    ASSERT_TRUE(uv);
    EXPECT_NEAR(stretch_energy(laid.disk.mesh.positions, laid.disk.mesh.faces, *uv), 1, 1e-3);
}

TEST(MultilevelMap, SameInputSameMap) {
    const Laid laid = lay(test::icosphere(5));
    const auto a = multilevel_stretch_map(laid.view(), {}, {}), b = multilevel_stretch_map(laid.view(), {}, {});
    ASSERT_TRUE(a && b);
    EXPECT_EQ(*a, *b);
}

}  // namespace
}  // namespace dgm::bake
