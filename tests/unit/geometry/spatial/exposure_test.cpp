// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/spatial/exposure_test.cpp
// Exposure against configuration factors known in closed form.
#include "geometry/spatial/exposure.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>

#include "support/meshes.h"

namespace dgm::bake {
namespace {
using model::TriMesh;
using model::Vec3d;

constexpr double kQuadrature = 2.5 / ExposureIndex::kRays;  // two rays are counted wrongly

/// A wall in x = distance, `height` high and as good as endless to the sides, about a floor in z = 0.
TriMesh wall(double distance, double height) {
    TriMesh mesh;
    constexpr double kFar = 1000;
    mesh.positions = {{distance, -kFar, 0}, {distance, kFar, 0}, {distance, kFar, height}, {distance, -kFar, height}};
    mesh.faces = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

/// The inside of a cylinder of radius 1 that stands on z = 0, open above.
TriMesh well(double depth) {
    TriMesh mesh;
    constexpr std::uint32_t kSides = 96;
    for (std::uint32_t k = 0; k < kSides; ++k) {
        const double turn = 2 * std::numbers::pi * k / kSides;
        for (const double z : {0.0, depth}) mesh.positions.push_back({std::cos(turn), std::sin(turn), z});
    }
    mesh.faces = test::lattice_faces(kSides, 2, true);
    return mesh;
}

TEST(Exposure, IsOneAllOverAConvexBody) {
    for (const double e : vertex_exposure(test::icosphere(3))) ASSERT_EQ(e, 1);
}

TEST(Exposure, AWallHidesItsConfigurationFactor) {
    // From a floor element to an endless wall of height h at distance d: (1 - d / sqrt(d^2 + h^2)) / 2.
    for (const double height : {0.5, 1.0, std::sqrt(3.0), 10.0}) {
        const double hidden = 0.5 * (1 - 1 / std::hypot(1, height));
        for (const Vec3d& towards : {Vec3d{1, 0, 0}, Vec3d{-1, 0, 0}})
            EXPECT_NEAR(ExposureIndex(wall(towards.x, height)).at({0, 0, 0}, {0, 0, 1}), 1 - hidden, kQuadrature)
                << height;
    }
}

TEST(Exposure, TheBottomOfAWellSeesTheSquareOfTheSine) {
    for (const double depth : {0.5, 1.0, 2.0})
        EXPECT_NEAR(ExposureIndex(well(depth)).at({0, 0, 0}, {0, 0, 1}), 1 / (1 + depth * depth), kQuadrature) << depth;
}

TEST(Exposure, TheOutsideOfTheWellIsInPlainView) {
    EXPECT_EQ(ExposureIndex(well(2)).at({1.001, 0, 1}, {1, 0, 0}), 1);
}

TEST(Exposure, PlaceSizeAndThreadsDoNotMatter) {
    const TriMesh mesh = test::torus(1, 0.4, 48, 24);
    const std::vector<double> here = vertex_exposure(mesh);
    // A power of two changes no digit of the coordinates.
    TriMesh large = mesh;
    for (Vec3d& p : large.positions) p = p * 1048576;
    EXPECT_EQ(vertex_exposure(large), here);
    {
        const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        EXPECT_EQ(vertex_exposure(mesh), here);
    }
    // The inner equator of a torus looks at itself, the outer one at nothing.
    double inner = 0, outer = 1;
    for (std::size_t v = 0; v < here.size(); ++v) {
        const double from_axis = std::hypot(mesh.positions[v].x, mesh.positions[v].y);
        if (from_axis < 0.61) inner = std::max(inner, here[v]);
        if (from_axis > 1.39) outer = std::min(outer, here[v]);
    }
    EXPECT_LT(inner, 0.8);
    EXPECT_EQ(outer, 1);
}

TEST(Exposure, WhatIsNotFiniteHidesNothing) {
    TriMesh mesh = wall(1, 10);
    mesh.positions[2].x = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(ExposureIndex(mesh).at({0, 0, 0}, {0, 0, 1}), 1) << "both faces hang on that vertex";
    const ExposureIndex whole(wall(1, 10));
    EXPECT_EQ(whole.at(mesh.positions[2], {0, 0, 1}), 1);
    EXPECT_EQ(whole.at({0, 0, 0}, {0, 0, 0}), 1);
    EXPECT_EQ(ExposureIndex(TriMesh{}).at({0, 0, 0}, {0, 0, 1}), 1);
}

}  // namespace
}  // namespace dgm::bake
