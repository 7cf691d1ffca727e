// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/cgal/exact_geodesics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/error.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

TEST(ExactGeodesics, ArePlaneDistancesOnASheet) {
    const model::TriMesh sheet = test::grid_sheet(12, 12);
    const std::uint32_t middle = 6 * 13 + 6;
    const std::vector<double> d = exact_geodesics(sheet.positions, sheet.faces, middle, 0.4);
    for (std::uint32_t v = 0; v < d.size(); ++v) {
        const double straight = length(sheet.positions[v] - sheet.positions[middle]);
        if (straight < 0.4 - 1e-12) {
            EXPECT_NEAR(d[v], straight, 1e-12) << v;
        } else if (straight > 0.4 + 1e-12) {
            EXPECT_TRUE(std::isinf(d[v])) << v;
        }
    }
}

TEST(ExactGeodesics, GoOverTheEdgeOfAFold) {
    // Two unit sheets at a right angle along x = 1: unfolded, the far corners are (0, 0) and (2, 1) apart.
    model::TriMesh fold;
    fold.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, 1}, {1, 1, 1}};
    fold.faces = {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}, {4, 5, 2}};
    EXPECT_NEAR(exact_geodesics(fold.positions, fold.faces, 0, 10)[5], std::sqrt(5.0), 1e-12);
}

TEST(ExactGeodesics, OtherSheetsAreOutOfReach) {
    model::TriMesh two;
    two.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.01}, {1, 0, 0.01}, {0, 1, 0.01}};
    two.faces = {{0, 1, 2}, {3, 4, 5}, {0, 1, 1}};  // the last has no area
    const std::vector<double> d = exact_geodesics(two.positions, two.faces, 0, 5);
    EXPECT_NEAR(d[1], 1, 1e-12);
    for (const std::uint32_t v : {3U, 4U, 5U}) EXPECT_TRUE(std::isinf(d[v]));
    EXPECT_THROW((void)exact_geodesics(two.positions, two.faces, 6, 5), model::Error);
}

}  // namespace
}  // namespace dgm::bake
