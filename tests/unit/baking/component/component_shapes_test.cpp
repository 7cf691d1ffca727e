// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/baking/component/component_shapes_test.cpp
#include "baking/component/component_shapes.h"

#include <gtest/gtest.h>

#include <numbers>

#include "support/meshes.h"

namespace dgm::bake {
namespace {

TEST(StripLength, IsLengthOverWidth) {
    // Edges of a sheet's triangles lead along its diagonal, or else around: 8 + 1, and 8 as the length of a diagonal.
    const double sheet = strip_length(test::grid_sheet(80, 10, 8, 1));
    EXPECT_GE(sheet, 8 + 1.0 / 8);
    EXPECT_LE(sheet, 81.0 / 8);
    // From the rim over the tip and back is no way; to the tip it is 20 and a quarter of a circle.
    const double rim = 2 * std::numbers::pi * 0.3, way = 20 + 0.25 * rim;
    const double area = rim * 20 + 2 * std::numbers::pi * 0.09;
    EXPECT_NEAR(strip_length(test::finger(0.3, 20, 16, 120, 8)), way * way / area, 1);
}

TEST(StripLength, IsOneForWhatIsNoStrip) {
    EXPECT_EQ(strip_length(test::icosphere(3)), 1);
    EXPECT_EQ(strip_length(test::grid_sheet(20, 10)), 1);
    EXPECT_EQ(strip_length(test::torus(1, 0.4, 40, 16)), 1);
    EXPECT_EQ(strip_length(test::comb(8, 60)), 1) << "long, but eight limbs";
}

}  // namespace
}  // namespace dgm::bake
