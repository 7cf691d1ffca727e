// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/parameterize/curved_rest_shapes_test.cpp
#include "geometry/parameterize/curved_rest_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/meshes.h"

namespace dgm::bake {
namespace {

using model::TriMesh;
using model::Vec3d;

/// Factor that the bending added to a face's weight: the area it weighs over its own at the same scale, and that in the
/// mesh.
std::vector<double> weights(const TriMesh& mesh) {
    const DiskView disk{mesh.positions, mesh.faces, {}, {}};
    const std::vector<RestShape> plain = rest_shapes(disk), curved = curved_rest_shapes(disk);
    std::vector<double> out;
    for (std::size_t f = 0; f < plain.size(); ++f) out.push_back(curved[f].area / plain[f].area);
    return out;
}

/// A sheet of width 1 along y whose one half, x < 0.5, is flat, and whose other half is rolled about radius `r`.
TriMesh half_rolled(std::uint32_t n, double r) {
    TriMesh sheet = test::grid_sheet(n, n);
    for (Vec3d& p : sheet.positions) {
        const double a = std::max(0.0, p.x - 0.5) / r;
        p = {std::min(p.x, 0.5) + r * std::sin(a), p.y, r * (1 - std::cos(a))};
    }
    return sheet;
}

/// Where a face of half_rolled() lies; neither beside the border, where smoothed normals end, or where the roll begins.
enum class Part { kNeither, kFlat, kRolled };
Part part_of(const TriMesh& mesh, std::size_t face, double r) {
    const auto q = mesh.corners(face);
    const Vec3d c = (q[0] + q[1] + q[2]) / 3;
    const double x = c.z > 1e-9 ? 0.5 + r * std::atan2(c.x - 0.5, r - c.z) : c.x;
    if (c.y < 0.15 || c.y > 0.85 || x > 0.85) return Part::kNeither;
    return x < 0.35 ? Part::kFlat : x > 0.65 ? Part::kRolled : Part::kNeither;
}

TEST(CurvedRestShapes, FlatSheetsHaveOneDensity) {
    for (const double w : weights(test::grid_sheet(20, 20))) EXPECT_NEAR(w, 1, 1e-9);
}

TEST(CurvedRestShapes, WeighBendingByItsSquareOverTheMean) {
    // |II| is 1/r on half of the area and 0 on the other: its mean is 1/2r, and the weight 1 + 4 and 1, whatever r is.
    for (const double r : {0.4, 2.0}) {
        const TriMesh mesh = half_rolled(60, r);
        const std::vector<double> w = weights(mesh);
        int flat = 0, rolled = 0;
        for (std::size_t f = 0; f < w.size(); ++f) {
            const Part part = part_of(mesh, f, r);
            if (part == Part::kFlat) {
                EXPECT_NEAR(w[f], 1, 0.01) << f;
                ++flat;
            }
            if (part == Part::kRolled) {
                EXPECT_NEAR(w[f], 5, 0.4) << f;
                ++rolled;
            }
        }
        EXPECT_GT(flat, 500);
        EXPECT_GT(rolled, 500);
    }
}

TEST(CurvedRestShapes, SharpEdgesWeighAHundredTimesAtMost) {
    TriMesh sheet = test::grid_sheet(80, 80);
    for (Vec3d& p : sheet.positions)
        if (p.x > 0.5) p = {0.5, p.y, p.x - 0.5};
    double most = 0;
    for (const double w : weights(sheet)) most = std::max(most, w);
    EXPECT_GT(most, 20);
    EXPECT_LE(most, 101 + 1e-9);
}

TEST(CurvedRestShapes, ScaleDoesNotMatter) {
    TriMesh mesh = half_rolled(20, 0.7);
    const std::vector<double> before = weights(mesh);
    for (Vec3d& p : mesh.positions) p *= 1000;
    const std::vector<double> after = weights(mesh);
    for (std::size_t f = 0; f < before.size(); ++f) EXPECT_NEAR(after[f], before[f], 1e-6 * before[f]);
}

/// By how much lengths are divided where a face is laid flat, at most and at least, and in which direction at most.
struct Laid {
    double along = 0, across = 0;
    Vec3d way;
};

std::vector<Laid> directed(const TriMesh& mesh) {
    const DiskView disk{mesh.positions, mesh.faces, {}, {}};
    const std::vector<RestShape> plain = rest_shapes(disk), to = directed_rest_shapes(disk);
    std::vector<Laid> out;
    for (std::size_t f = 0; f < plain.size(); ++f) {
        EXPECT_EQ(to[f].area, plain[f].area);  // the weight of a face stays
        // M with M hat = hat' for two of the corners; a symmetric matrix of two unequal eigenvalues.
        const Vec2d a = plain[f].hat[1], b = plain[f].hat[2], ma = to[f].hat[1], mb = to[f].hat[2];
        const double d = cross(a, b), xx = (ma.x * b.y - mb.x * a.y) / d, xy = (mb.x * a.x - ma.x * b.x) / d,
                     yx = (ma.y * b.y - mb.y * a.y) / d, yy = (mb.y * a.x - ma.y * b.x) / d;
        EXPECT_NEAR(xy, yx, 1e-9 * (std::abs(xx) + std::abs(yy)));
        const double mean = (xx + yy) / 2, half = std::sqrt((xx - yy) * (xx - yy) / 4 + xy * xy);
        const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
        const auto q = mesh.corners(f);
        const Vec3d x = (q[1] - q[0]) / length(q[1] - q[0]), n = cross(x, q[2] - q[0]), y = cross(n / length(n), x);
        out.push_back({mean + half, mean - half, x * std::cos(angle) + y * std::sin(angle)});
    }
    return out;
}

TEST(DirectedRestShapes, CellsOnARolledSheetAreTwiceAsLongAsWide) {
    // Half of the area bends by 1/r one way, half not at all: the mean of both curvatures is 1/4r. What is flat counts
    // as half of that, 1/8r, and along the axis a quarter of 1/r counts. In the metric |II| the sheet has the area
    // (1/2r + 1/8r) / 2 = 0.3125/r, and lengths are divided by the root of that over their curvature.
    const double r = 0.4;
    const TriMesh mesh = half_rolled(60, r);
    const std::vector<Laid> laid = directed(mesh);
    int flat = 0, rolled = 0;
    for (std::size_t f = 0; f < laid.size(); ++f) {
        const Part part = part_of(mesh, f, r);
        if (part == Part::kFlat) {
            EXPECT_NEAR(laid[f].along, std::sqrt(8 * 0.3125), 0.06);
            EXPECT_NEAR(laid[f].across, std::sqrt(8 * 0.3125), 0.06);
            ++flat;
        }
        if (part == Part::kRolled) {
            EXPECT_NEAR(laid[f].along, std::sqrt(4 * 0.3125), 0.05);
            EXPECT_NEAR(laid[f].across, std::sqrt(0.3125), 0.025);
            EXPECT_NEAR(std::abs(laid[f].way.y), 1, 1e-3);  // lengths along the axis of the roll are divided by most
            ++rolled;
        }
    }
    EXPECT_GT(flat, 500);
    EXPECT_GT(rolled, 500);
}

TEST(DirectedRestShapes, WhatBendsAlikeEverywhereOrNowhereKeepsItsShape) {
    const TriMesh sphere = test::icosphere(4);
    for (const Laid& l : directed(sphere)) EXPECT_LT(l.along, 1.1 * l.across);
    for (const Laid& l : directed(test::grid_sheet(20, 20))) {
        EXPECT_NEAR(l.along, 1, 1e-9);
        EXPECT_NEAR(l.across, 1, 1e-9);
    }
}

TEST(DirectedRestShapes, LaidFlatAllFacesTogetherHaveTheAreaOfTheSquare) {
    // Bent one way, both ways and with a crease; at any scale.
    TriMesh mesh = half_rolled(40, 0.3);
    for (Vec3d& p : mesh.positions) p = p * 37 + Vec3d{0, 0, p.y * p.y};
    const std::vector<RestShape> to = directed_rest_shapes({mesh.positions, mesh.faces, {}, {}});
    double area = 0;
    for (const RestShape& shape : to) area += 0.5 / cross(shape.hat[1], shape.hat[2]);
    EXPECT_NEAR(area, 1, 1e-9);
}

}  // namespace
}  // namespace dgm::bake
