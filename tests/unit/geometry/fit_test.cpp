// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/fit_test.cpp
#include "geometry/fit/fit.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "geometry/chart/square_chart.h"
#include "geometry/cut/cut_graph.h"
#include "geometry/fit/least_squares.h"
#include "geometry/parameterize/square_border.h"
#include "geometry/repair/repair.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

const std::vector<char> kFree{0};

TEST(LeastSquares, OneUnknownIsTheWeightedMean) {
    // Gaps 3 and 6 with weights 2 and 1, no damping to speak of: (2*3 + 1*6) / 3 = 4.
    const std::vector<FitRow> rows{{{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {0, 0, 1}, 2},
                                   {{0, 0, 0}, {1, 0, 0}, {6, 0, 0}, {0, 0, 1}, 1}};
    const auto step = least_squares_step(rows, 1, kFree, 1.0, 1e-12, 10);
    EXPECT_NEAR(step[0].x, 4, 1e-9);
    EXPECT_NEAR(step[0].y, 0, 1e-12);
}

TEST(LeastSquares, PlaneRowsLeaveTheTangentFree) {
    // One plane row along (1, 1, 0)/sqrt2 with a gap of (2, 0, 0): only the normal part, (1, 1, 0), is asked for.
    const double s = std::sqrt(0.5);
    const std::vector<FitRow> rows{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {s, s, 0}, 1}};
    const auto step = least_squares_step(rows, 1, kFree, 0.0, 1e-9, 10);
    EXPECT_NEAR(step[0].x, 1, 1e-6);
    EXPECT_NEAR(step[0].y, 1, 1e-6);
}

TEST(LeastSquares, FixedUnknownsStay) {
    const std::vector<FitRow> rows{{{0, 1, 1}, {0.5, 0.5, 0}, {1, 0, 0}, {0, 0, 1}, 1}};
    const std::vector<char> fixed{1, 0};
    const auto step = least_squares_step(rows, 2, fixed, 1.0, 1e-12, 10);
    EXPECT_EQ(step[0], Vec3d{});
    EXPECT_NEAR(step[1].x, 2, 1e-9);  // half of it carries the whole gap
}

struct Case {
    TriMesh component;
    SampledChart chart;
};

Case square_case(const TriMesh& mesh, std::uint32_t side) {
    Case c{repair(mesh).components.at(0), {}};
    CutGraph cut(c.component);
    cut.cut_to_disk();
    const Disk disk = cut.open();
    c.chart = make_square_chart(disk, side, side, candidate_rotations(disk, side, side, 1).front(),
                                *make_stretch_parameterizer(5), {});
    return c;
}

/// Faces of a chart of a ball round the origin that look inward.
int inward_faces(const SampledChart& chart) {
    int inward = 0;
    for (const Face& f : chart.faces()) {
        const Vec3d &a = chart.positions[f[0]], &b = chart.positions[f[1]], &c = chart.positions[f[2]];
        inward += dot(cross(b - a, c - a), a + b + c) <= 0;
    }
    return inward;
}

TEST(Fit, BeatsSamplingOnABallAndKeepsSeams) {
    const Case c = square_case(test::icosphere(5), 33);
    const double sampled = quick_error(c.component, c.chart, 20000).psnr();
    EXPECT_GT(inward_faces(c.chart), 0);  // beside the zigzag of the cut; what the fit has to mend
    for (const FitOptions& options : {l2_fit(), best_fit()}) {
        SampledChart fitted = c.chart;
        const FitReport report = fit_chart(c.component, fitted, options, {});
        const SurfaceError error = quick_error(c.component, fitted, 20000);
        // Samples on a ball leave all the error inside; the best planes of the same grid leave a third of it. There is
        // nowhere on a ball to slide to, so both fits gain about the same.
        EXPECT_GT(error.psnr(), sampled + 5);
        EXPECT_LT(report.rms, report.start_rms);
        for (std::size_t s = 0; s < fitted.positions.size(); ++s)
            ASSERT_EQ(fitted.positions[s], fitted.positions[fitted.representative[s]]);
        EXPECT_EQ(welded_topology(fitted), welded_topology(c.chart));
        EXPECT_EQ(inward_faces(fitted), 0) << options.rounds;
    }
}

TEST(Fit, SlidesToWhereTheErrorIs) {
    TriMesh drop = test::icosphere(5);
    for (Vec3d& p : drop.positions) {
        const double narrow = 0.15 + 0.85 * (1 - p.x) / 2;  // a sharp nose at +x
        p = {1.6 * p.x, narrow * p.y, narrow * p.z};
    }
    const Case c = square_case(drop, 33);
    SampledChart plain = c.chart, slid = c.chart;
    fit_chart(c.component, plain, l2_fit(), {});
    fit_chart(c.component, slid, best_fit(), {});
    EXPECT_GT(quick_error(c.component, slid, 20000).psnr(), quick_error(c.component, plain, 20000).psnr() + 1);
}

TEST(Fit, RealBordersStay) {
    TriMesh dome = test::grid_sheet(24, 24);
    for (Vec3d& p : dome.positions) p.z = 0.3 * std::sin(3 * p.x) * std::cos(2 * p.y);
    const Case c = square_case(dome, 17);
    SampledChart fitted = c.chart;
    fit_chart(c.component, fitted, best_fit(), {});
    std::size_t moved = 0;
    for (std::uint32_t i = 0; i < 17; ++i)
        for (std::uint32_t j = 0; j < 17; ++j) {
            const std::size_t s = i * 17 + j;
            if (i == 0 || j == 0 || i == 16 || j == 16)
                ASSERT_EQ(fitted.positions[s], c.chart.positions[s]);
            else
                moved += fitted.positions[s] != c.chart.positions[s];
        }
    EXPECT_GT(moved, 100u);
}

TEST(Fit, SameBitsForAnyNumberOfThreads) {
    const Case c = square_case(test::icosphere(4), 25);
    std::vector<Vec3d> first;
    for (std::size_t threads : {1, 2}) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        SampledChart fitted = c.chart;
        fit_chart(c.component, fitted, best_fit(), {});
        if (first.empty()) first = fitted.positions;
        EXPECT_EQ(fitted.positions, first);
    }
}

TEST(Fit, ClosestSamplesOfAnUnfittedChartLieOnItsSamples) {
    const Case c = square_case(test::icosphere(4), 17);
    const SampleGrid grid = closest_samples(c.chart, 33, 33);
    EXPECT_EQ(grid.missing, 0u);
    for (std::uint32_t i = 0; i < 17; ++i)
        for (std::uint32_t j = 0; j < 17; ++j) {
            const Vec3d p = position_at(c.chart.disk.mesh, grid.samples[std::size_t{2 * i} * 33 + 2 * j]);
            EXPECT_LT(length(p - c.chart.positions[i * 17 + j]), 1e-9);
        }
}

}  // namespace
}  // namespace dgm::bake
