// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/metrics/same_places_test.cpp
#include "geometry/metrics/same_places.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <tuple>

namespace dgm::bake {
namespace {

using model::Vec3d;

TEST(SamePlaces, NamesTheFirstPointAtEachPlace) {
    const std::vector<Vec3d> points{{1, 2, 3}, {0.0, 0, 0}, {1, 2, 3}, {-0.0, 0, -0.0}, {3, 2, 1}, {1, 2, 3}};
    EXPECT_EQ(first_at_same_place(points), (std::vector<std::uint32_t>{0, 1, 0, 1, 4, 0}));
    EXPECT_TRUE(first_at_same_place({}).empty());
}

TEST(SamePlaces, AgreesWithAMapOfPlaces) {
    std::mt19937_64 random(3);
    std::vector<Vec3d> points(20'000);
    for (Vec3d& p : points)
        p = {static_cast<double>(random() % 16), static_cast<double>(random() % 16),
             0.5 * static_cast<double>(random() % 16)};
    const std::vector<std::uint32_t> found = first_at_same_place(points);
    std::map<std::tuple<double, double, double>, std::uint32_t> first;
    for (std::uint32_t k = 0; k < points.size(); ++k)
        ASSERT_EQ(found[k], first.try_emplace({points[k].x, points[k].y, points[k].z}, k).first->second);
}

}  // namespace
}  // namespace dgm::bake
