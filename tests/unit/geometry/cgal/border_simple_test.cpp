// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/cgal/border_simple_test.cpp
#include "geometry/cgal/border_simple.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace dgm::bake {
namespace {
using model::Vec2d;
using Polygon = std::vector<Vec2d>;

TEST(BorderSimple, AcceptsConvexAndConcavePolygonsInBothDirections) {
    EXPECT_TRUE(border_is_simple(Polygon{{0, 0}, {1, 0}, {0, 1}}));
    EXPECT_TRUE(border_is_simple(Polygon{{0, 1}, {1, 0}, {0, 0}}));
    EXPECT_TRUE(border_is_simple(Polygon{{0, 0}, {4, 0}, {4, 4}, {2, 1}, {0, 4}}));
}

TEST(BorderSimple, RejectsCrossingsTouchesAndRepeatedPoints) {
    EXPECT_FALSE(border_is_simple(Polygon{{0, 0}, {1, 1}, {1, 0}, {0, 1}}));                  // bow tie
    EXPECT_FALSE(border_is_simple(Polygon{{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}}));          // corner on an edge
    EXPECT_FALSE(border_is_simple(Polygon{{0, 0}, {2, 0}, {1, 1}, {2, 2}, {0, 2}, {1, 1}}));  // pinched
    EXPECT_FALSE(border_is_simple(Polygon{{0, 0}, {0, 0}, {1, 0}, {0, 1}}));
}

TEST(BorderSimple, DecidesWithinOneUlp) {
    // The notch ends just above or exactly on the bottom edge.
    const double tiny = std::numeric_limits<double>::denorm_min();
    EXPECT_TRUE(border_is_simple(Polygon{{0, 0}, {4, 0}, {4, 4}, {2, tiny}, {0, 4}}));
    EXPECT_FALSE(border_is_simple(Polygon{{0, 0}, {4, 0}, {4, 4}, {2, -tiny}, {0, 4}}));
}

TEST(BorderSimple, RejectsWhatIsNoPolygon) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    EXPECT_FALSE(border_is_simple(Polygon{}));
    EXPECT_FALSE(border_is_simple(Polygon{{0, 0}, {1, 0}}));
    EXPECT_FALSE(border_is_simple(Polygon{{0, 0}, {1, 0}, {nan, 1}}));
    EXPECT_FALSE(border_is_simple(Polygon{{0, 0}, {inf, 0}, {0, 1}}));
}
}  // namespace
}  // namespace dgm::bake
