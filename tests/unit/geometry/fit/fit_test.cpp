// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/fit/fit_test.cpp
#include "geometry/fit/fit.h"
#include "geometry/fit/closest_samples.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "geometry/chart/square_chart.h"
#include "geometry/cut/cut_graph.h"
#include "geometry/fit/normal_equations.h"
#include "geometry/fit/search_repair.h"
#include "geometry/fit/sliding.h"
#include "geometry/mesh/triangle.h"
#include "geometry/metrics/turned_faces.h"
#include "geometry/parameterize/square_border.h"
#include "geometry/repair/repair.h"
#include "support/meshes.h"
#include "support/sheet_chart.h"

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

const std::vector<Freedom> kFirstFree{Freedom::kFree, Freedom::kHeld, Freedom::kHeld, Freedom::kHeld};

TEST(NormalEquations, OneUnknownIsTheWeightedMean) {
    const WeldedGrid grid(one_quad());
    NormalEquations equations(grid);
    // Gaps 3 and 6 with weights 2 and 1, hardly any damping: (2*3 + 1*6) / 3 = 4.
    equations.add(0, {1, 0, 0}, {3, 0, 0}, {1, 0, 0}, 2);
    equations.add(0, {1, 0, 0}, {6, 0, 0}, {1, 0, 0}, 1);
    const auto step = equations.solve(kFirstFree, {}, 1e-12, 10);
    EXPECT_NEAR(step[0].x, 4, 1e-9);
    EXPECT_NEAR(step[0].y, 0, 1e-12);
}

TEST(NormalEquations, RowsLeaveTheTangentFree) {
    const WeldedGrid grid(one_quad());
    NormalEquations equations(grid);
    // One row along (1, 1, 0)/sqrt2 with a gap of (2, 0, 0): only the normal part, (1, 1, 0), is asked for.
    const double s = std::sqrt(0.5);
    equations.add(0, {1, 0, 0}, {2, 0, 0}, {s, s, 0}, 1);
    const auto step = equations.solve(kFirstFree, {}, 1e-9, 10);
    EXPECT_NEAR(step[0].x, 1, 1e-6);
    EXPECT_NEAR(step[0].y, 1, 1e-6);
}

/// A row asks for x = 3, with as much weight as the damping has: halfway from where the step goes of itself. Nothing
/// asks anything along y and z, and there the step goes on.
TEST(NormalEquations, WhereNothingIsAskedTheStepGoesOn) {
    const WeldedGrid grid(one_quad());
    NormalEquations equations(grid);
    equations.add(0, {1, 0, 0}, {3, 0, 0}, {1, 0, 0}, 1);
    const std::vector<Vec3d> onward{{1, 0.25, -0.5}, {7, 7, 7}, {}, {}};
    const auto step = equations.solve(kFirstFree, {}, 1, 10, onward);
    EXPECT_NEAR(step[0].x, 2, 1e-5) << "and the floor of the damping";
    EXPECT_NEAR(step[0].y, 0.25, 1e-12);
    EXPECT_NEAR(step[0].z, -0.5, 1e-12);
    EXPECT_EQ(step[1], Vec3d{}) << "held";
}

TEST(NormalEquations, FixedClassesStayAndTheOthersCarryTheGap) {
    const WeldedGrid grid(one_quad());
    NormalEquations equations(grid);
    equations.add(0, {0.5, 0.5, 0}, {1, 0, 0}, {1, 0, 0}, 1);
    const auto step = equations.solve(
        std::vector<Freedom>{Freedom::kHeld, Freedom::kHeld, Freedom::kFree, Freedom::kHeld}, {}, 1e-12, 10);
    EXPECT_EQ(step[0], Vec3d{});
    EXPECT_NEAR(step[2].x, 2, 1e-9);  // half of it carries the whole gap
}

TEST(NormalEquations, RailsAreNotLeft) {
    const WeldedGrid grid(one_quad());
    NormalEquations equations(grid);
    // Wanted: (3, 1, 0), each coordinate by a row of its own. Along (0.6, 0.8, 0) the nearest is (3*0.6 + 0.8) = 2.6.
    equations.add(0, {1, 0, 0}, {3, 0, 0}, {1, 0, 0}, 1);
    equations.add(0, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}, 1);
    const auto step =
        equations.solve(std::vector<Freedom>{Freedom::kSlides, Freedom::kHeld, Freedom::kHeld, Freedom::kHeld},
                        std::vector<Vec3d>{{0.6, 0.8, 0}, {}, {}, {}}, 1e-12, 10);
    EXPECT_NEAR(step[0].x, 2.6 * 0.6, 1e-9);
    EXPECT_NEAR(step[0].y, 2.6 * 0.8, 1e-9);
}

TEST(NormalEquations, SnapsIntoThePlaneThatTheRowsAskFor) {
    const WeldedGrid grid(one_quad());
    NormalEquations equations(grid);
    const Vec3d normal = normalized(Vec3d{1, 2, 5});
    equations.add(0, {1, 0, 0}, {0, 0, 0}, normal, 1);  // stay in the plane through the origin
    std::vector<Vec3d> at{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}};
    const Lattice lattice{{-10.4, -10.3, -10.2}, 1};
    const std::vector<char> first{1, 0, 0, 0}, none(4, 0);
    equations.snap(at, lattice, kFirstFree, first, none, [](std::uint32_t) { return 0; });
    // The nearest lattice point is (-0.4, -0.3, -0.2); by trying all around it, another is nearer to the plane.
    double least = INFINITY;
    for (int k = 0; k < 27; ++k)
        least = std::min(least, std::abs(dot(normal, Vec3d{-0.4 + k % 3 - 1, -0.3 + k / 3 % 3 - 1, -0.2 + k / 9 - 1})));
    EXPECT_NEAR(std::abs(dot(normal, at[0])), least, 1e-12);
    EXPECT_LT(least, std::abs(dot(normal, Vec3d{-0.4, -0.3, -0.2})));
    EXPECT_LT(length(at[0] - lattice.nearest(at[0])), 1e-12);
    EXPECT_EQ(at[3], (Vec3d{1, 1, 0}));
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

TEST(PreparedTriangle, HasTheSquaredDistancesOfClosestOnTriangleBitForBit) {
    const std::array<std::array<Vec3d, 3>, 3> triangles{{{{{0.1, 0, 0.2}, {1, 0.3, 0}, {0.2, 1.1, 0.4}}},
                                                         {{{0, 0, 0}, {1, 0, 0}, {0.5, 1e-9, 0}}},
                                                         {{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}}}};
    for (const auto& q : triangles) {
        const PreparedTriangle prepared(q);
        for (int k = 0; k < 343; ++k) {
            const Vec3d p{k % 7 / 2.3 - 1, k / 7 % 7 / 2.1 - 1, k / 49 / 1.9 - 1};
            std::array<double, 3> b{};
            EXPECT_EQ(prepared.squared_distance(p), closest_on_triangle(p, q, b)) << k;
        }
    }
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

/// A strip bent into a hairpin: a match that sits on the other leg cannot walk back, and stands off by the gap.
TEST(Matches, SettleOnTheLegThatIsCloser) {
    constexpr std::uint32_t kAlong = 84, kAcross = 9;
    TriMesh strip;
    for (std::uint32_t i = 0; i < kAlong; ++i) {
        const double t = 21.0 * i / (kAlong - 1);  // ten along a leg, one across the bend, ten back
        const Vec3d at = t < 10 ? Vec3d{t, 0, 0} : t < 11 ? Vec3d{10, 0, t - 10} : Vec3d{21 - t, 0, 1};
        for (std::uint32_t j = 0; j < kAcross; ++j) strip.positions.push_back(at + Vec3d{0, 0.25 * j, 0});
    }
    for (std::uint32_t i = 0; i + 1 < kAlong; ++i)
        for (std::uint32_t j = 0; j + 1 < kAcross; ++j) {
            const std::uint32_t a = i * kAcross + j, b = a + 1, c = a + kAcross, d = c + 1;
            strip.faces.push_back({a, c, d});
            strip.faces.push_back({a, d, b});
        }
    const Case c = square_case(strip, 33);
    const LinkedSurface source = link_source(*c.chart.disk);
    const ClosestPointIndex index(source.positions, source.faces);
    WeldedGrid grid(c.chart);
    Matches matches(c.chart, source, grid, 1000);
    matches.update(false);
    // Repair has put the middle of the bounding box into the origin and its diagonal to 1.
    const Vec3d centre{5, 1, 0.5};
    const double diagonal = std::hypot(10, 2, 1);
    const auto middle = [&](std::uint32_t f) { return matches.middles[f].position * diagonal + centre; };
    std::uint32_t face = 0;  // of the grid, in the midst of a leg
    while (std::abs(middle(face).x - 3) > 0.5 || std::abs(middle(face).y - 1) > 0.5) ++face;
    const Vec3d across{middle(face).x, middle(face).y, 1 - middle(face).z};
    matches.middles[face].hit.face = index.query((across - centre) / diagonal).face;
    matches.update(true);
    ASSERT_NEAR(std::sqrt(matches.middles[face].hit.squared) * diagonal, 1, 0.1);
    ASSERT_GT(matches.largest * diagonal, 0.9);
    matches.settle_farthest(index);
    EXPECT_LT(matches.largest * diagonal, 0.4);
    EXPECT_NEAR(matches.middles[face].hit.squared, 0, 1e-9);
}

/// A flat square sheet as a grid that lies on it: all that a step needs.
struct Sheet {
    Case made;
    LinkedSurface source;
    WeldedGrid grid;
    Matches matches;
    BorderRails rails;
    std::vector<Vec3d> upward;

    explicit Sheet(std::uint32_t side)
        : made(square_case(test::grid_sheet(side - 1, side - 1), side)),
          source(link_source(*made.chart.disk)),
          grid(made.chart),
          matches(made.chart, source, grid, 1000),
          rails(made.chart, source, grid),
          upward(source.normals) {
        matches.update(true);
    }
    [[nodiscard]] Sliding sliding() { return {grid, matches, rails, upward, grid.on_border}; }
    [[nodiscard]] std::uint32_t class_at(std::uint32_t i, std::uint32_t j) const {
        return grid.class_of[i * made.chart.n + j];
    }
    [[nodiscard]] Vec3d at(std::uint32_t c) const { return grid.surface.positions[c]; }
};

TEST(WeldedGrid, FaceAtIsOneOfTheQuadThatThePlaceFallsIn) {
    const Sheet sheet(9);
    const SampledChart& chart = sheet.made.chart;
    for (std::uint32_t i = 0; i + 1 < chart.m; ++i)
        for (std::uint32_t j = 0; j + 1 < chart.n; ++j) {
            const std::uint32_t face = sheet.grid.face_at(chart, Vec2d{(i + 0.3) / 8, (j + 0.6) / 8});
            std::vector<std::uint32_t> corners;
            for (const std::uint32_t di : {0U, 1U})
                for (const std::uint32_t dj : {0U, 1U}) corners.push_back(sheet.class_at(i + di, j + dj));
            for (const std::uint32_t c : sheet.grid.surface.faces[face])
                EXPECT_NE(std::find(corners.begin(), corners.end(), c), corners.end()) << i << ' ' << j;
        }
    EXPECT_NE(sheet.grid.face_at(chart, Vec2d{1, 1}), kNone);
    EXPECT_NE(sheet.grid.face_at(chart, Vec2d{-1e-9, 1 + 1e-9}), kNone);
}

TEST(Matches, NameTheFacesBeyondADistance) {
    Sheet sheet(9);
    EXPECT_TRUE(sheet.matches.faces_beyond(1e-6).empty());
    const std::uint32_t c = sheet.class_at(4, 4);
    sheet.grid.surface.positions[c] += sheet.grid.surface.normals[0] * 0.02;
    sheet.grid.surface.update_normals();
    sheet.matches.update(true);
    EXPECT_TRUE(sheet.matches.faces_beyond(0.0201).empty());
    std::vector<std::uint32_t> around;
    for (std::uint32_t f = 0; f < sheet.grid.surface.faces.size(); ++f)
        if (const Face& v = sheet.grid.surface.faces[f]; v[0] == c || v[1] == c || v[2] == c) around.push_back(f);
    EXPECT_EQ(sheet.matches.faces_beyond(0.0199), around);
}

TEST(Sliding, TakesWhatTurnsNothingWhole) {
    Sheet sheet(9);
    const std::uint32_t c = sheet.class_at(4, 4);
    const Vec3d up = sheet.grid.surface.normals[0], before = sheet.at(c);
    const double edge = length(sheet.at(sheet.class_at(4, 5)) - before);
    const Vec3d by = up * (0.2 * edge) + (sheet.at(sheet.class_at(4, 5)) - before) * 0.1;
    std::vector<Vec3d> step(sheet.grid.sample_of.size(), Vec3d{});
    step[c] = by;
    const std::vector<Vec3d> start = sheet.grid.surface.positions;
    sheet.sliding().take(step, {});
    EXPECT_LT(length(sheet.at(c) - (before + by)), 1e-12);
    for (std::uint32_t k = 0; k < start.size(); ++k)
        if (k != c) { EXPECT_EQ(sheet.at(k), start[k]); }
    std::vector<Vec3d> normals = sheet.grid.surface.normals;
    sheet.grid.surface.update_normals();
    EXPECT_EQ(sheet.grid.surface.normals, normals);
}

TEST(Sliding, StopsBeforeAFaceTurnsAndHoldsTheBorder) {
    Sheet sheet(9);
    const Vec3d up = sheet.grid.surface.normals[0];
    std::vector<Vec3d> step(sheet.grid.sample_of.size(), Vec3d{});
    // All to one side and neighbours through one another: either alone would turn faces.
    for (std::uint32_t i = 0; i < 9; ++i)
        for (std::uint32_t j = 0; j < 9; ++j) {
            const Vec3d along = sheet.at(sheet.class_at(4, 5)) - sheet.at(sheet.class_at(4, 4));
            step[sheet.class_at(i, j)] = along * (j % 2 == 0 ? 3.0 : -3.0) + up * (i % 2 == 0 ? 0.5 : -0.5);
        }
    const std::vector<Vec3d> start = sheet.grid.surface.positions;
    sheet.sliding().take(step, {});
    std::size_t moved = 0;
    for (std::uint32_t c = 0; c < start.size(); ++c) {
        moved += sheet.at(c) != start[c] ? 1 : 0;
        if (sheet.grid.on_border[c]) { EXPECT_EQ(sheet.at(c), start[c]); }
    }
    EXPECT_GT(moved, 20U);
    for (const Vec3d& n : sheet.grid.surface.normals) EXPECT_GT(dot(n, up), 0.29);
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

/// The same sheet, sampled well and badly: the bad one is far behind after a round.
TEST(FitTrials, EndTheOneThatIsClearlyBehindAfterARound) {
    const auto sheet = [] {
        return fit_test::sheet_chart(17, 24, [](double x, double y) { return 0.3 * x * x + y * y; });
    };
    SampledChart good = sheet(), bad = sheet();
    for (std::size_t s = 0; s < bad.positions.size(); ++s)
        if (bad.representative[s] == s && s / 17 % 16 != 0 && s % 17 % 16 != 0)
            bad.positions[s].z += s % 2 ? 0.02 : -0.02;
    const std::vector<Vec3d> before = bad.positions;
    std::optional<TrialFit> first, second;
    fit_trials({{{good, first}, {bad, second}}}, 1.15, {});
    EXPECT_EQ(bad.positions, before);
    EXPECT_GT(second->first_rms, 1.15 * first->first_rms);
    EXPECT_EQ(second->rms, second->first_rms);
    EXPECT_LT(first->rms, first->first_rms);
    const TrialFit alone = trial_fit(good, {});
    EXPECT_EQ(first->placement.positions, alone.placement.positions);
    EXPECT_EQ(first->rms, alone.rms);
    // Without a bound both go on to the end, from the trial that is there already.
    second.reset();
    fit_trials({{{good, first}, {bad, second}}}, 1e9, {});
    EXPECT_EQ(first->rms, alone.rms);
    EXPECT_LT(second->rms, second->first_rms);
}

/// A trial that has left samples off the edges of a cube: the fit begins with the map's, as if there had been none.
TEST(FitTrials, DoNotKeepSamplesFromEdges) {
    const Case c = square_case(test::cubes(std::array<std::array<int, 3>, 1>{{{0, 0, 0}}}), 33);
    SampledChart alone = c.chart, after_trial = c.chart;
    TrialFit trial = trial_fit(after_trial, {});
    ASSERT_EQ(after_trial.positions, c.chart.positions);
    for (std::size_t s = 0; s < trial.placement.positions.size(); ++s)
        if (c.chart.representative[s] == s && s / 33 % 32 != 0 && s % 33 % 32 != 0)
            trial.placement.positions[s].z += s % 2 ? 0.005 : -0.005;
    const FitReport expected = fit_chart(alone, l2_fit(), {});
    const FitReport report = fit_chart(after_trial, l2_fit(), {}, &trial);
    EXPECT_EQ(after_trial.positions, alone.positions);
    EXPECT_EQ(after_trial.diagonals, alone.diagonals);
    EXPECT_EQ(report.rms, expected.rms);
    EXPECT_EQ(report.start_rms, trial.start_rms);
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

std::vector<std::uint32_t> turned_faces(const ClosestPointIndex& index, const WeldedGrid& grid) {
    TriMesh surface;
    surface.positions = grid.surface.positions;
    surface.faces = grid.surface.faces;
    return find_turned_faces(index, surface, kTurnedTie);
}

TEST(TurnBack, UndoesAFoldOfSomeSamplesAndLeavesTheOthersAlone) {
    Case c = square_case(test::icosphere(5), 33);
    // Two rows change places: no single sample can go back without turning others.
    for (const std::size_t j : {15, 16, 17, 18})
        std::swap(c.chart.positions[16 * 33 + j], c.chart.positions[17 * 33 + j]);
    ASSERT_GT(inward_faces(c.chart), 8);
    const auto search = [&](std::span<const char> held) {
        const LinkedSurface source = link_source(*c.chart.disk);
        const ClosestPointIndex index(source.positions, source.faces);
        WeldedGrid grid(c.chart);
        Matches matches(c.chart, source, grid, 1000);
        matches.update(false);
        const std::vector<char> none(grid.sample_of.size(), 0);
        const std::vector<std::uint32_t> turned = turned_faces(index, grid);
        SearchEffort effort;
        const bool moved = repair_by_search(source, index, grid, matches,
                                            held.empty() ? std::span<const char>(none) : held, turned, effort);
        EXPECT_LE(effort.tries, SearchEffort{}.tries);
        EXPECT_EQ(effort.tries < SearchEffort{}.tries, held.empty());
        EXPECT_EQ(moved, held.empty());
        SampledChart out = c.chart;
        grid.write_positions(out);
        return out;
    };
    const SampledChart mended = search({});
    EXPECT_EQ(inward_faces(mended), 0);
    std::size_t changed = 0;
    for (std::size_t s = 0; s < mended.positions.size(); ++s) {
        changed += mended.positions[s] != c.chart.positions[s];
        EXPECT_EQ(mended.positions[s], mended.positions[mended.representative[s]]);
        EXPECT_NEAR(length(mended.positions[s]), length(c.chart.positions[s]), 0.01);  // on the ball as they were
    }
    EXPECT_GT(changed, 1);
    EXPECT_LT(changed, 100);
    EXPECT_EQ(search({}).positions, mended.positions);  // the same each time
    const std::vector<char> all(WeldedGrid(c.chart).sample_of.size(), 1);
    EXPECT_EQ(search(all).positions, c.chart.positions);
}

TEST(TurnBack, GivesOneHopelessFaceMoreTriesAndKeepsSomeForTheNext) {
    Case c = square_case(test::icosphere(4), 17);
    std::swap(c.chart.positions[8 * 17 + 8], c.chart.positions[8 * 17 + 9]);
    const LinkedSurface source = link_source(*c.chart.disk);
    const ClosestPointIndex index(source.positions, source.faces);
    const auto tries_made = [&](std::size_t most_a_face) {
        WeldedGrid grid(c.chart);
        Matches matches(c.chart, source, grid, 1000);
        matches.update(false);
        const std::vector<std::uint32_t> turned = turned_faces(index, grid);
        EXPECT_GT(turned.size(), 0u);
        std::vector<char> held(grid.sample_of.size(), 0);  // its corners alone: what may move cannot turn it
        for (const std::uint32_t v : grid.surface.faces[turned.front()]) held[v] = 1;
        SearchEffort effort;
        effort.tries = 400'000;
        effort.most_a_face = most_a_face;
        repair_by_search(source, index, grid, matches, held, std::span(turned).first(1), effort);
        return 400'000 - effort.tries;
    };
    const std::size_t few = tries_made(3'000), many = tries_made(30'000);
    EXPECT_GT(few, 0u);
    EXPECT_GT(many, 5 * few);
    EXPECT_LT(many, 210'000u);
}

double to_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
    const double squared = dot(b - a, b - a);
    const double t = squared > 0 ? std::clamp(dot(p - a, b - a) / squared, 0.0, 1.0) : 0.0;
    return length(p - a - (b - a) * t);
}

using Segments = std::vector<std::array<Vec3d, 2>>;

/// Edges that one face only has, by their ends' positions.
Segments border_of(const std::vector<Vec3d>& positions, const std::vector<Face>& faces) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
    for (const Face& f : faces)
        for (int k = 0; k < 3; ++k) ++uses[std::minmax(f[k], f[(k + 1) % 3])];
    Segments out;
    for (const auto& [edge, count] : uses)
        if (count == 1) out.push_back({positions[edge.first], positions[edge.second]});
    return out;
}

Segments border_of(const SampledChart& chart) {
    std::vector<Face> faces = chart.faces();
    for (Face& f : faces)
        for (std::uint32_t& s : f) s = chart.representative[s];
    return border_of(chart.positions, faces);
}

/// Largest distance from points along `from` to `to`.
double farthest(const Segments& from, const Segments& to) {
    double out = 0;
    for (const auto& [a, b] : from)
        for (int k = 0; k <= 8; ++k) {
            double least = INFINITY;
            for (const auto& [c, d] : to) least = std::min(least, to_segment(a + (b - a) * (k / 8.0), c, d));
            out = std::max(out, least);
        }
    return out;
}

/// A sheet whose outline has a sharp notch where no sample of the start is.
TriMesh notched_sheet() {
    TriMesh sheet = test::grid_sheet(40, 40);
    for (Vec3d& p : sheet.positions) {
        const double notch = std::max(0.0, 0.12 - std::abs(p.x - 0.525)) * (1 - p.y);
        p = {p.x, p.y + 1.5 * notch, 0.2 * std::sin(3 * p.x) * std::cos(2 * p.y)};
    }
    return sheet;
}

/// Vertices in one face only.
std::vector<Vec3d> sheet_corners(const TriMesh& mesh) {
    std::vector<int> uses(mesh.positions.size(), 0);
    for (const Face& f : mesh.faces)
        for (const std::uint32_t v : f) ++uses[v];
    std::vector<Vec3d> out;
    for (std::size_t v = 0; v < uses.size(); ++v)
        if (uses[v] == 1) out.push_back(mesh.positions[v]);
    return out;
}

TEST(Fit, RealBordersSlideAlongThemselves) {
    const Case c = square_case(notched_sheet(), 17);
    const Segments source = border_of(c.component.positions, c.component.faces);
    const double start = farthest(source, border_of(c.chart));
    ASSERT_FALSE(sheet_corners(c.component).empty());
    ASSERT_GT(start, 0.005);  // the notch's tip is cut off
    for (const FitOptions& options : {l2_fit(), best_fit()}) {
        SampledChart fitted = c.chart;
        fit_chart(fitted, options, {});
        std::size_t moved = 0;
        for (std::uint32_t i = 0; i < 17; ++i)
            for (std::uint32_t j = 0; j < 17; ++j) {
                const std::size_t s = i * 17 + j;
                if (i != 0 && j != 0 && i != 16 && j != 16) continue;
                const Vec3d& p = fitted.positions[s];
                double least = INFINITY;
                for (const auto& [a, b] : source) least = std::min(least, to_segment(p, a, b));
                ASSERT_LT(least, 1e-12);
                ASSERT_LT(length(position_at(fitted.disk->mesh, fitted.samples[s]) - p), 1e-12);
                moved += p != c.chart.positions[s];
            }
        EXPECT_GT(moved, 10u);
        for (const Vec3d& corner : sheet_corners(c.component)) {
            const auto here = [&](const Vec3d& p) { return length(p - corner) < 1e-12; };
            EXPECT_TRUE(std::any_of(fitted.positions.begin(), fitted.positions.end(), here));
        }
        const Segments border = border_of(fitted);
        EXPECT_LT(std::max(farthest(source, border), farthest(border, source)), 0.25 * start) << options.rounds;
        EXPECT_EQ(welded_topology(fitted), welded_topology(c.chart));
    }
}

TEST(Fit, PositionsOnALatticeCostNoAccuracy) {
    const Case c = square_case(test::icosphere(5), 33);
    SampledChart free = c.chart, snapped = c.chart;
    FitOptions options = l2_fit();
    fit_chart(free, options, {});
    options.on_lattice = true;
    fit_chart(snapped, options, {});
    ASSERT_TRUE(snapped.lattice.has_value());
    const Lattice& lattice = *snapped.lattice;
    for (std::size_t s = 0; s < snapped.positions.size(); ++s) {
        ASSERT_EQ(snapped.positions[s], snapped.positions[snapped.representative[s]]);
        ASSERT_LT(length(snapped.positions[s] - lattice.nearest(snapped.positions[s])), 1e-6 * lattice.step);
    }
    EXPECT_GT(quick_error(c.component, snapped, 20000).psnr(), quick_error(c.component, free, 20000).psnr() - 0.1);
    EXPECT_EQ(inward_faces(snapped), 0);
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
            const Vec3d p = position_at(c.chart.disk->mesh, grid.samples[std::size_t{2 * i} * 33 + 2 * j]);
            EXPECT_LT(length(p - c.chart.positions[i * 17 + j]), 1e-9);
        }
}

}  // namespace
}  // namespace dgm::bake
