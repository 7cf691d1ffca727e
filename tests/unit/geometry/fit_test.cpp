// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/fit_test.cpp
#include "geometry/fit/fit.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "geometry/chart/square_chart.h"
#include "geometry/cut/cut_graph.h"
#include "geometry/fit/normal_equations.h"
#include "geometry/parameterize/square_border.h"
#include "geometry/repair/repair.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {

/// One quad over the unit square: classes 0 (0,0), 1 (0,1), 2 (1,0), 3 (1,1); face 0 is 0, 2, 3.
SampledChart one_quad() {
    SampledChart chart;
    chart.m = chart.n = 2;
    chart.positions = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}};
    chart.representative = {0, 1, 2, 3};
    chart.diagonals = {0};
    return chart;
}

TEST(NormalEquations, OneUnknownIsTheWeightedMean) {
    const WeldedGrid grid(one_quad());
    NormalEquations equations(grid);
    // Gaps 3 and 6 with weights 2 and 1, no damping to speak of: (2*3 + 1*6) / 3 = 4.
    equations.add(0, {1, 0, 0}, {3, 0, 0}, {1, 0, 0}, 2);
    equations.add(0, {1, 0, 0}, {6, 0, 0}, {1, 0, 0}, 1);
    const auto step = equations.solve(std::vector<char>{0, 1, 1, 1}, 1e-12, 10);
    EXPECT_NEAR(step[0].x, 4, 1e-9);
    EXPECT_NEAR(step[0].y, 0, 1e-12);
}

TEST(NormalEquations, RowsLeaveTheTangentFree) {
    const WeldedGrid grid(one_quad());
    NormalEquations equations(grid);
    // One row along (1, 1, 0)/sqrt2 with a gap of (2, 0, 0): only the normal part, (1, 1, 0), is asked for.
    const double s = std::sqrt(0.5);
    equations.add(0, {1, 0, 0}, {2, 0, 0}, {s, s, 0}, 1);
    const auto step = equations.solve(std::vector<char>{0, 1, 1, 1}, 1e-9, 10);
    EXPECT_NEAR(step[0].x, 1, 1e-6);
    EXPECT_NEAR(step[0].y, 1, 1e-6);
}

TEST(NormalEquations, FixedClassesStayAndTheOthersCarryTheGap) {
    const WeldedGrid grid(one_quad());
    NormalEquations equations(grid);
    equations.add(0, {0.5, 0.5, 0}, {1, 0, 0}, {1, 0, 0}, 1);
    const auto step = equations.solve(std::vector<char>{1, 1, 0, 1}, 1e-12, 10);
    EXPECT_EQ(step[0], Vec3d{});
    EXPECT_NEAR(step[2].x, 2, 1e-9);  // half of it carries the whole gap
}

TEST(LinkedSurface, ClosestPointOfATriangleInEachRegion) {
    const std::array<Vec3d, 3> q{Vec3d{0, 0, 0}, Vec3d{2, 0, 0}, Vec3d{0, 2, 0}};
    std::array<double, 3> b;
    EXPECT_DOUBLE_EQ(closest_on_triangle({0.5, 0.5, 3}, q, b), 9);
    EXPECT_DOUBLE_EQ(b[0], 0.5);
    EXPECT_DOUBLE_EQ(closest_on_triangle({1, -2, 0}, q, b), 4);
    EXPECT_DOUBLE_EQ(b[1], 0.5);
    EXPECT_DOUBLE_EQ(closest_on_triangle({2, 2, 0}, q, b), 2);  // middle of the long edge, (1, 1, 0)
    EXPECT_DOUBLE_EQ(b[0], 0);
    EXPECT_DOUBLE_EQ(closest_on_triangle({-3, -4, 0}, q, b), 25);
    EXPECT_DOUBLE_EQ(b[0], 1);
    const std::array<Vec3d, 3> flat{Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{3, 0, 0}};  // no area
    EXPECT_DOUBLE_EQ(closest_on_triangle({2, 1, 0}, flat, b), 1);
}

/// A ball's distance has one local minimum for points outside it, so a walk must find what trying all faces finds.
TEST(LinkedSurface, WalksAcrossTheCutToTheClosestPointOfABall) {
    const TriMesh ball = repair(test::icosphere(4)).components.at(0);
    CutGraph cut(ball);
    cut.cut_to_disk();
    const LinkedSurface source = link_source(cut.open());
    for (int k = 0; k < 200; ++k) {
        const double z = -1 + (k + 0.5) / 100, r = std::sqrt(1 - z * z), a = 2.4 * k;
        const Vec3d p = Vec3d{r * std::cos(a), r * std::sin(a), z} * (1.0 + 0.01 * (k % 7));
        double least = INFINITY;
        std::array<double, 3> b;
        for (std::size_t f = 0; f < source.faces.size(); ++f)
            least = std::min(least, closest_on_triangle(p, source.corners(f), b));
        const SurfaceHit hit = walk_to_closest(source, p, static_cast<std::uint32_t>(37 * k % source.faces.size()));
        EXPECT_NEAR(hit.squared, least, 1e-12);
        EXPECT_NEAR(length(point_at(source, hit) - p), std::sqrt(hit.squared), 1e-9);
    }
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
    for (const FitOptions& options : {l2_fit(), best_fit()}) {
        SampledChart fitted = c.chart;
        const FitReport report = fit_chart(fitted, options, {});
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
    SampledChart fitted = c.chart;
    fit_chart(fitted, best_fit(), {});
    // As many samples on the ball gain 5 to 6 dB (above); here they gather at the nose.
    EXPECT_GT(quick_error(c.component, fitted, 20000).psnr(), quick_error(c.component, c.chart, 20000).psnr() + 8);
    double tip = 0;
    for (const Vec3d& p : c.component.positions) tip = std::max(tip, p.x);
    const auto beyond = [&](const SampledChart& chart) {
        int count = 0;
        for (const Vec3d& p : chart.positions) count += p.x > 0.8 * tip;
        return count;
    };
    EXPECT_GT(beyond(fitted), beyond(c.chart));
}

TEST(Fit, MendsFacesThatTheStartTurns) {
    Case c = square_case(test::icosphere(5), 33);
    // Sample (16, 16) goes beyond its neighbour (16, 18): the faces between them look inward.
    const std::size_t s = 16 * 33 + 16;
    c.chart.positions[s] = c.chart.positions[s + 2] * 2 - c.chart.positions[s + 1];
    c.chart.samples[s] = c.chart.samples[s + 2];
    const int turned = inward_faces(c.chart);
    ASSERT_GT(turned, 0);
    for (const FitOptions& options : {l2_fit(), best_fit()}) {
        SampledChart fitted = c.chart;
        fit_chart(fitted, options, {});
        EXPECT_EQ(inward_faces(fitted), 0) << options.rounds;
    }
}

TEST(Fit, RealBordersStay) {
    TriMesh dome = test::grid_sheet(24, 24);
    for (Vec3d& p : dome.positions) p.z = 0.3 * std::sin(3 * p.x) * std::cos(2 * p.y);
    const Case c = square_case(dome, 17);
    SampledChart fitted = c.chart;
    fit_chart(fitted, best_fit(), {});
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
        fit_chart(fitted, best_fit(), {});
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
