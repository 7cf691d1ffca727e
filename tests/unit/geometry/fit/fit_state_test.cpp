// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/fit/fit_state_test.cpp
// The rails of the source's border, and the state that a fit keeps and goes back to.
#include "geometry/fit/fit_state.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "geometry/fit/border_rails.h"
#include "support/sheet_chart.h"

namespace dgm::bake {
namespace {

TEST(BorderRails, HoldCornersAndLetTheOthersSlideAlongTheirSide) {
    fit_test::FitCase c(fit_test::flat_chart(9, 12));
    const BorderRails& rails = c.fit.rails;
    for (std::uint32_t i = 0; i < 9; ++i)
        for (std::uint32_t j = 0; j < 9; ++j) {
            const std::uint32_t k = c.class_at(i, j);
            const bool on_x = j % 8 == 0, on_y = i % 8 == 0;  // a side along x or along y
            const Freedom expected = on_x && on_y ? Freedom::kHeld : on_x || on_y ? Freedom::kSlides : Freedom::kFree;
            EXPECT_EQ(rails.freedom()[k], expected) << i << ' ' << j;
            const Vec3d d = rails.directions()[k];
            EXPECT_NEAR(std::abs(d.x), expected == Freedom::kSlides && on_x ? 1 : 0, 1e-12);
            EXPECT_NEAR(std::abs(d.y), expected == Freedom::kSlides && on_y ? 1 : 0, 1e-12);
        }
    EXPECT_NEAR(rails.largest_gap(), 0, 1e-12);
    for (const double way : rails.ways_to_corners()) EXPECT_EQ(way, 0) << "each corner has its stop";
}

TEST(BorderRails, StopsSlideAlongTheBorderAndEndAtACorner) {
    fit_test::FitCase c(fit_test::flat_chart(9, 12));
    BorderRails& rails = c.fit.rails;
    const std::uint32_t k = c.class_at(3, 0);
    const Vec3d at = c.position(k), along = rails.directions()[k];
    EXPECT_GT(rails.reach(k), 0);
    EXPECT_LT(2 * rails.reach(k), 1.0 / 8) << "two neighbours cannot meet";
    EXPECT_NEAR(length(rails.place_after(k, 0.04) - (at + along * 0.04)), 0, 1e-12);
    const Vec3d end = rails.place_after(k, 5);  // longer than the border
    EXPECT_NEAR(length(end - (along.x > 0 ? Vec3d{1, 0, 0} : Vec3d{0, 0, 0})), 0, 1e-12);

    const std::vector<double> places = rails.places();
    const std::pair<std::uint32_t, double> way{k, 0.04};
    rails.slide({&way, 1});
    EXPECT_TRUE(rails.has_moved(k));
    EXPECT_FALSE(rails.has_moved(c.class_at(4, 0)));
    EXPECT_FALSE(rails.has_moved(c.class_at(4, 4))) << "it is not on the border";
    EXPECT_NEAR(length(position_at(c.chart.disk->mesh, rails.sample(k)) - (at + along * 0.04)), 0, 1e-12);
    rails.set_places(places);
    EXPECT_FALSE(rails.has_moved(k));
    EXPECT_EQ(rails.places(), places);
}

/// The sides along y bulge as the parabola z = 4 h y (1 - y). Its chord from y = 0 to 1/2 is farthest from it at 1/4:
/// by h / 4 upwards, and by that times the cosine of the chord's slope across it.
TEST(BorderRails, GapIsTheRiseOfTheBorderOverItsChord) {
    constexpr double kHeight = 0.01;
    fit_test::FitCase c(fit_test::sheet_chart(3, 64, [](double, double y) { return 4 * kHeight * y * (1 - y); }));
    EXPECT_NEAR(c.fit.rails.largest_gap(), kHeight / 4 / std::hypot(1, kHeight / 0.5), 1e-9);
}

/// One end of two chords under the parabola moves to where the squared gaps are least. With the gap 4 h s (1/2 - s)
/// over a chord and the hat function 2 s, that is the integral of their product over that of the hat's square:
/// (h / 24) / (1 / 6) = h / 4.
TEST(BorderRails, RowsPullTheChordTowardsTheBorder) {
    fit_test::FitCase c(fit_test::sheet_chart(3, 64, [](double, double y) { return 0.04 * y * (1 - y); }));
    NormalEquations equations(c.fit.grid);
    c.fit.rails.add_rows(equations, 1, [](double) { return 1.0; });
    std::vector<Freedom> freedom(9, Freedom::kHeld);
    const std::uint32_t k = c.class_at(0, 1);
    freedom[k] = Freedom::kFree;
    const Vec3d step = equations.solve(freedom, {}, 1e-9, 100)[k];
    EXPECT_NEAR(step.z, 0.01 / 4, 5e-5);
    EXPECT_NEAR(step.x, 0, 1e-9);
}

TEST(FitState, GoesBackToWhatItKept) {
    fit_test::FitCase c(fit_test::flat_chart(9, 12));
    FitState& fit = c.fit;
    fit.keep();
    const FitState::Kept first = fit.kept;
    EXPECT_NEAR(first.largest, 0, 1e-12);
    const std::uint32_t k = c.class_at(4, 4);
    c.position(k) += Vec3d{0, 0, 0.05};
    c.chart.diagonals[30] = 1;
    fit.relink();
    const std::pair<std::uint32_t, double> way{c.class_at(3, 0), 0.03};
    fit.rails.slide({&way, 1});
    fit.matches.update(true);
    EXPECT_NEAR(fit.largest(), 0.05, 1e-9);
    fit.keep();
    EXPECT_NEAR(fit.kept.largest, 0.05, 1e-9);
    EXPECT_NE(fit.kept.positions, first.positions);
    fit.go_back_to(first);
    EXPECT_EQ(fit.grid.surface.positions, first.positions);
    EXPECT_EQ(c.chart.diagonals[30], 0);
    EXPECT_EQ(fit.rails.places(), first.places);
    EXPECT_NEAR(fit.matches.largest, 0, 1e-12);
}

TEST(FitState, AStepBringsTheGridDown) {
    fit_test::FitCase c(fit_test::flat_chart(9, 12));
    for (std::uint32_t k = 0; k < 81; ++k)
        if (!c.fit.grid.on_border[k]) c.position(k).z += 0.01;
    c.look();
    const double before = c.fit.matches.rms;
    c.fit.step(false);
    c.fit.matches.update(true);
    EXPECT_LT(c.fit.matches.rms, 0.1 * before);
    for (std::uint32_t k = 0; k < 81; ++k)
        if (c.fit.grid.on_border[k]) { EXPECT_NEAR(c.position(k).z, 0, 1e-12) << "the border stays on its rails"; }
}

/// One sample off the surface: the faces around it and four rings of samples are the region, and nothing else moves.
TEST(Region, IsAroundWhatIsFarOffAndNothingElseMoves) {
    fit_test::FitCase c(fit_test::flat_chart(25, 12));
    c.position(c.class_at(12, 12)).z += 0.01;
    c.position(c.class_at(3, 20)).z += 0.001;
    c.look();
    const Region region = around_far(c.fit.grid, c.fit.matches, 0.005);
    ASSERT_FALSE(region.is_whole());
    EXPECT_EQ(region.classes[c.class_at(12, 12)], 1);
    EXPECT_EQ(region.classes[c.class_at(12, 17)], 1) << "a corner of the faces around it, and four rings";
    EXPECT_EQ(region.classes[c.class_at(12, 18)], 0);
    EXPECT_EQ(region.classes[c.class_at(3, 20)], 0) << "near enough";
    fit_test::FitCase lifted(fit_test::flat_chart(9, 12));
    for (std::uint32_t k = 0; k < 81; ++k) lifted.position(k).z += 0.01;
    lifted.look();
    EXPECT_TRUE(around_far(lifted.fit.grid, lifted.fit.matches, 0.005).is_whole());

    const std::vector<Vec3d> before = c.fit.grid.surface.positions;
    c.fit.step(true, region);
    for (std::size_t k = 0; k < before.size(); ++k)
        if (!region.classes[k]) { EXPECT_EQ(c.fit.grid.surface.positions[k], before[k]); }
    EXPECT_NEAR(c.position(c.class_at(12, 12)).z, 0, 1e-3);
}

/// A fold of the grid lies nearer to the middle of the source than the faces that walks find: settling finds it among
/// the faces in reach of it.
TEST(Matches, SettleFarthestFindsTheFaceThatIsNearest) {
    fit_test::FitCase c(fit_test::flat_chart(33, 12));
    for (std::uint32_t i = 0; i < 33; ++i)
        for (std::uint32_t j = 0; j < 33; ++j) {
            const double x = i / 32.0, y = j / 32.0;  // rolled up: the far end comes to lie over the first third
            const double z = x < 0.5 ? 0.2 : 0.02;
            c.position(c.class_at(i, j)) = {x < 0.5 ? x : 1 - x, y, z};
        }
    c.look();
    c.fit.matches.settle_farthest(c.fit.inverted.source_index());
    const ClosestPointIndex all(c.fit.grid.surface.positions, c.fit.grid.surface.faces);
    for (const Match& m : c.fit.matches.points) {
        const double nearest = all.query(m.position).distance;
        if (m.hit.squared > 0.25 * c.fit.matches.largest * c.fit.matches.largest) {
            EXPECT_NEAR(std::sqrt(m.hit.squared), nearest, 1e-9);
        }
    }
}

TEST(FitState, TakesBackTheCornersOfFreshlyInvertedFacesAlone) {
    fit_test::FitCase c(fit_test::flat_chart(9, 12));
    const std::vector<Vec3d> before = c.fit.grid.surface.positions;
    const std::uint32_t sound = c.class_at(6, 6);
    c.position(sound) += Vec3d{0.01, 0.01, 0};
    c.invert_at(2, 2);
    std::vector<char> went_back(before.size(), 0);
    EXPECT_TRUE(c.fit.take_back(
        before, [&] { return c.fit.inverted.faces(); }, went_back));
    EXPECT_TRUE(fit_test::faces_upside_down(c.fit.grid.surface).empty());
    EXPECT_EQ(c.position(c.class_at(2, 2)), before[c.class_at(2, 2)]);
    EXPECT_EQ(went_back[c.class_at(2, 2)], 1);
    EXPECT_EQ(went_back[sound], 0);
    EXPECT_EQ(c.position(sound), before[sound] + (Vec3d{0.01, 0.01, 0}));
    const auto never_empty = [] { return std::vector<std::uint32_t>{0}; };
    EXPECT_FALSE(c.fit.take_back(before, never_empty));
}

TEST(FitState, FlipsTheQuadOfAnArrowheadAndSplitsQuadsByTheError) {
    SampledChart chart = fit_test::sheet_chart(9, 8, [](double x, double y) { return 0.5 * std::abs(x - y); });
    chart.diagonals.assign(64, 1);
    fit_test::FitCase c(std::move(chart));
    const double before = c.fit.matches.rms;
    c.fit.split_quads();
    EXPECT_LT(c.fit.matches.rms, 0.7 * before) << "all quads on the ridge but the two at its ends";
    fit_test::FitCase flat(fit_test::flat_chart(9, 12));
    const std::vector<std::uint32_t> faces{50};
    EXPECT_FALSE(flat.fit.flip_quads(faces, false)) << "nothing is wrong with it";
}

/// At a corner of the map where the border is straight, three samples lie in a line: a diagonal between the outer two
/// would leave a face without height, which rounding may turn.
TEST(FitState, NoDiagonalCutsOffACornerOfAStraightBorder) {
    SampledChart chart = fit_test::flat_chart(9, 12);
    const std::size_t beside = 1, below = 9;
    chart.positions[0] = (chart.positions[beside] + chart.positions[below]) / 2;
    EXPECT_TRUE(splits_badly(chart, 0, 0, 1));
    EXPECT_FALSE(splits_badly(chart, 0, 0, 0));
    EXPECT_FALSE(splits_badly(chart, 4, 4, 0));
    EXPECT_FALSE(splits_badly(chart, 4, 4, 1));
    chart.diagonals[0] = 1;
    fit_test::FitCase c(std::move(chart));
    EXPECT_EQ(c.fit.inverted.faces({}, true), (std::vector<std::uint32_t>{0})) << "rounding may turn it";
    c.fit.split_quads();
    EXPECT_EQ(c.chart.diagonals[0], 0);
    EXPECT_TRUE(c.fit.inverted.faces({}, true).empty());
}

/// Twice the points for `l2` on a large grid with a dense source, where they are not too many; the usual ones
/// everywhere else.
TEST(FitState, GivesALargeGridOfADenseSourceMorePoints) {
    constexpr std::uint32_t kLarge = 174, kSmall = 173;  // 30,276 and 29,929 samples
    const auto points_a_sample = [](std::uint32_t side, std::uint32_t source_side, const FitOptions& options) {
        SampledChart chart = fit_test::flat_chart(side, source_side);
        const FitState fit(chart, options);
        EXPECT_EQ(fit.has_dense_points, fit.points_a_sample > options.points_per_sample);
        return static_cast<double>(fit.matches.area_points) / static_cast<double>(chart.grid_count());
    };
    FitOptions plain, many = l2_fit();
    many.points_of_dense = 80;  // 2.4 million
    EXPECT_NEAR(points_a_sample(kLarge, 120, l2_fit()), 16, 0.01);
    EXPECT_NEAR(points_a_sample(kLarge, 120, best_fit()), 8, 0.01);
    EXPECT_NEAR(points_a_sample(kLarge, 100, l2_fit()), 8, 0.01) << "a third of a facet a face";
    EXPECT_NEAR(points_a_sample(kSmall, 120, l2_fit()), 8, 0.01) << "a small grid";
    EXPECT_NEAR(points_a_sample(kLarge, 120, plain), 8, 0.01) << "not asked for";
    EXPECT_NEAR(points_a_sample(kLarge, 120, many), 8, 0.01) << "beyond what memory is worth";
}

TEST(Without, LeavesOutWhatIsKnown) {
    EXPECT_EQ(without({1, 2, 5, 9}, {2, 3, 9}), (std::vector<std::uint32_t>{1, 5}));
    EXPECT_TRUE(without({4}, {4}).empty());
}

/// Work is counted, not timed: a fit ends at its bound with the best state so far, the same every time.
TEST(Fit, EndsAtTheBoundOfItsWork) {
    const auto wavy = [](double x, double y) { return 0.2 * std::sin(9 * x) * std::cos(7 * y); };
    const auto fitted = [&](std::uint64_t most, SampledChart& chart) {
        FitOptions options = best_fit();
        options.most_looks = most;
        return fit_chart(chart, options, {});
    };
    SampledChart whole = fit_test::sheet_chart(17, 24, wavy), cut = whole, again = whole;
    const SampledChart start = whole;
    const FitReport all = fitted(0, whole);
    EXPECT_FALSE(all.ended_early);
    EXPECT_GT(all.looked, 1000U);
    EXPECT_LT(all.looked, most_looks_of(start.grid_count()) / 10) << "ordinary charts are far from the bound";
    const FitReport early = fitted(all.looked / 3, cut);
    EXPECT_TRUE(early.ended_early);
    EXPECT_LT(early.looked, all.looked);
    EXPECT_LT(early.rounds, all.rounds);
    EXPECT_LT(early.rms, early.start_rms) << "what was reached is kept";
    EXPECT_NE(cut.positions, start.positions);
    EXPECT_EQ(fitted(all.looked / 3, again).looked, early.looked);
    EXPECT_EQ(again.positions, cut.positions);
}

}  // namespace
}  // namespace dgm::bake
