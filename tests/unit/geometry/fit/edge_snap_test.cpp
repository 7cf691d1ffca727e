// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/fit/edge_snap_test.cpp
// Samples go to edges of the source that the grid's faces lie across.
#include "geometry/fit/edge_snap.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "geometry/chart/square_chart.h"
#include "geometry/fit/grid_cells.h"
#include "geometry/fit/ring_error.h"
#include "geometry/parameterize/square_border.h"
#include "support/sheet_chart.h"

namespace dgm::bake {
namespace {

/// A sheet of few facets with slopes of up to 1 : 4 to all sides.
SampledChart facets(std::uint32_t side, std::uint32_t cells) {
    return fit_test::sheet_chart(
        side, cells, [](double x, double y) { return 0.1 * std::sin(19 * x + 3 * y) * std::cos(23 * y - 5 * x); });
}

/// A roof whose ridge at x = 1/2 lies midway between two rows of samples.
TEST(EdgeSnap, PutsARowOfSamplesOnTheRidgeOfARoof) {
    fit_test::FitCase c(fit_test::sheet_chart(8, 2, [](double x, double) { return 0.5 - std::abs(x - 0.5); }));
    ASSERT_GT(c.fit.matches.largest, 0.03);
    const std::vector<Vec3d> before = c.fit.grid.surface.positions;
    ASSERT_TRUE(snap_to_edges(c.fit));
    for (std::uint32_t j = 1; j < 7; ++j) {
        const Vec3d a = c.position(c.class_at(3, j)), b = c.position(c.class_at(4, j));
        EXPECT_TRUE(a.x == 0.5 || b.x == 0.5) << j << ": " << a.x << ' ' << b.x;
    }
    for (std::uint32_t f = 0; f < c.fit.grid.surface.faces.size(); ++f) {
        const auto q = c.fit.grid.surface.corners(f);
        EXPECT_GT(cross(q[1] - q[0], q[2] - q[0]).z, 1e-4) << f;
        bool inside = true;
        for (const Vec3d& p : q) inside = inside && p.y > 0 && p.y < 1;
        const double lowest = std::min({q[0].x, q[1].x, q[2].x}), highest = std::max({q[0].x, q[1].x, q[2].x});
        EXPECT_FALSE(inside && lowest < 0.5 - 1e-12 && highest > 0.5 + 1e-12) << "face " << f << " lies across";
    }
    for (std::uint32_t k = 0; k < 8; ++k)
        for (const std::uint32_t border : {c.class_at(k, 0), c.class_at(k, 7), c.class_at(0, k), c.class_at(7, k)})
            EXPECT_EQ(c.position(border), before[border]) << k;
}

TEST(EdgeSnap, MovesNothingWhereNoErrorIs) {
    fit_test::FitCase c(fit_test::flat_chart(9, 3));
    EXPECT_FALSE(snap_to_edges(c.fit));
}

TEST(EdgeSnap, LowersTheErrorOfASheetOfFacets) {
    fit_test::FitCase c(facets(40, 8));
    const double before = c.fit.matches.rms;
    ASSERT_TRUE(snap_to_edges(c.fit));
    EXPECT_LT(c.fit.matches.rms, 0.6 * before);
    EXPECT_TRUE(fit_test::faces_upside_down(c.fit.grid.surface).empty());
}

TEST(EdgeSnap, HelpsTheFit) {
    double rms[2];
    for (const int snaps : {0, 2}) {
        SampledChart chart = facets(40, 8);
        FitOptions options = l2_fit();
        options.snaps = snaps;
        rms[snaps / 2] = fit_chart(chart, options, {}).rms;
    }
    EXPECT_LT(rms[1], 0.8 * rms[0]);
}

TEST(EdgeSnap, SameBitsForAnyNumberOfThreads) {
    std::vector<Vec3d> positions;
    std::vector<std::uint8_t> diagonals;
    for (const std::size_t threads : {1, 2}) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        fit_test::FitCase c(facets(64, 12));
        ASSERT_TRUE(snap_to_edges(c.fit));
        if (positions.empty()) {
            positions = c.fit.grid.surface.positions;
            diagonals = c.chart.diagonals;
        }
        EXPECT_EQ(c.fit.grid.surface.positions, positions);
        EXPECT_EQ(c.chart.diagonals, diagonals);
    }
}

/// Each triangle's weight is its area; of a sheet lifted by h each point and each middle is h away.
TEST(RingError, OfALiftedSheetIsTheSquareOfTheLift) {
    constexpr double kLift = 0.01;
    fit_test::FitCase c(fit_test::flat_chart(9, 12));
    for (Vec3d& p : c.fit.grid.surface.positions) p.z += kLift;
    c.look();
    const GridCells cells(c.chart, c.fit.grid);
    std::vector<std::vector<std::uint32_t>> points(cells.size());
    for (std::uint32_t k = 0; k < c.fit.matches.area_points; ++k)
        points[cells.cell_of(c.fit.matches.points[k].hit.face)].push_back(k);
    const std::vector<char> may_flip(cells.size(), 1);
    constexpr double kPerArea = 7;
    const RingSurroundings around{c.fit.source, cells,   c.fit.grid.surface.positions, c.fit.matches, points,
                                  may_flip,     kPerArea};
    RingError ring(around);
    const std::uint32_t at = c.class_at(4, 4);
    RingBounds bounds;
    const RingPlace present = ring.present(at, bounds);
    double count = 0;
    for (const std::uint32_t cell : cells.around(at)) count += static_cast<double>(points[cell].size());
    const double expected = kLift * kLift * (count + kPerArea * 4.0 / 64);
    EXPECT_NEAR(present.error, expected, 1e-9 * expected);
    EXPECT_NEAR(bounds.upright, 1, 1e-12);
    EXPECT_NEAR(bounds.thickness, 0.5, 1e-12) << "half a square: its area twice over its diagonal squared";

    RingPlace down{c.position(at) - Vec3d{0, 0, kLift}, 0, {}};
    ASSERT_TRUE(ring.measure(at, bounds = {0.3, 0.04}, present.error, down));
    EXPECT_LT(down.error, present.error);
    EXPECT_GT(down.error, 0.2 * present.error) << "its neighbours are up still";
    RingPlace beyond{c.position(c.class_at(6, 4)), 0, {}};
    EXPECT_FALSE(ring.measure(at, bounds, 1e9, beyond)) << "faces would fold";
}

TEST(GridCells, AreTheQuadsAroundEachClassWhicheverWayTheyAreSplit) {
    const TriMesh ball = test::icosphere(2);
    CutGraph cut(ball);
    cut.cut_to_disk();
    const Disk disk = cut.open();
    const std::uint32_t rotation = candidate_rotations(disk, 9, 9, 1).front();
    fit_test::FitCase c(make_square_chart(disk, 9, 9, rotation, *make_stretch_parameterizer(5), {}));
    const GridCells cells(c.chart, c.fit.grid);
    EXPECT_EQ(cells.size(), 64U);
    for (std::uint32_t cell = 0; cell < cells.size(); ++cell) {
        const std::uint32_t quad = cells.quad(cell), i = quad / 8, j = quad % 8;
        const std::set<std::uint32_t> corners{c.class_at(i, j), c.class_at(i + 1, j), c.class_at(i, j + 1),
                                              c.class_at(i + 1, j + 1)};
        for (std::uint32_t v = 0; v < c.fit.grid.surface.positions.size(); ++v) {
            const auto around = cells.around(v);
            EXPECT_EQ(std::count(around.begin(), around.end(), cell), corners.count(v)) << cell << ' ' << v;
        }
        const CellFaces now = cells.faces(cell, c.chart.diagonals[quad]);
        ASSERT_EQ(now.count, 2);
        for (std::uint32_t f = 0; f < 2; ++f) {
            EXPECT_EQ(now.faces[f], c.fit.grid.surface.faces[cells.first_face(cell) + f]);
            EXPECT_EQ(cells.cell_of(cells.first_face(cell) + f), cell);
        }
    }
}

}  // namespace
}  // namespace dgm::bake
