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
            const auto q = mesh.corners(f);
            const Vec3d c = (q[0] + q[1] + q[2]) / 3;
            const double x = c.z > 1e-9 ? 0.5 + r * std::atan2(c.x - 0.5, r - c.z) : c.x;
            if (c.y < 0.15 || c.y > 0.85 || x > 0.85) continue;  // smoothed normals end at the border
            if (x < 0.35) {
                EXPECT_NEAR(w[f], 1, 0.01) << x;
                ++flat;
            }
            if (x > 0.65) {
                EXPECT_NEAR(w[f], 5, 0.4) << x;
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

}  // namespace
}  // namespace dgm::bake
