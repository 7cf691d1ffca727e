// SPDX-License-Identifier: GPL-3.0-or-later
#include "baking/search/size_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace dgm::bake {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double side_of(GridSize size) {
    return std::sqrt(static_cast<double>(size.rows) * size.cols);
}

std::size_t first_65(const std::vector<GridSize>& ladder) {
    std::size_t k = 0;
    while (k + 1 < ladder.size() && side_of(ladder[k]) < 65) ++k;
    return k;
}

/// Promise of every search: the answer was measured and holds, the step before it was measured and does not.
void expect_bracket(const SizeSearch& search, double asked) {
    ASSERT_TRUE(search.found);
    bool answer = false, before = *search.found == 0;
    for (const SizeTrial& trial : search.trials) {
        if (trial.step == *search.found) answer = trial.value <= asked;
        if (trial.step + 1 == *search.found) before = trial.value > asked;
    }
    EXPECT_TRUE(answer);
    EXPECT_TRUE(before);
}

TEST(GridOf, HoldsTheNumberAndTheAspectWithEvenIntervals) {
    EXPECT_EQ(grid_of(66049, 1), (GridSize{257, 257}));
    EXPECT_EQ(grid_of(66048, 1), (GridSize{255, 259}));  // one too few for the square; 66045
    EXPECT_EQ(grid_of(9, 1), (GridSize{3, 3}));
    for (const std::uint64_t samples : {1000ULL, 4225ULL, 66049ULL, 1000000ULL})
        for (const double aspect : {0.25, 0.5, 1.0, std::sqrt(2.0), 4.0}) {
            const GridSize size = grid_of(samples, aspect);
            EXPECT_LE(std::uint64_t{size.rows} * size.cols, samples);
            EXPECT_EQ(size.rows % 2, 1U);
            EXPECT_EQ(size.cols % 2, 1U);
            // No row and column pair more would fit.
            EXPECT_GT(std::uint64_t{size.rows + 2} * (size.cols + 2), samples);
            EXPECT_NEAR(std::log((size.rows - 1.0) / (size.cols - 1.0) / aspect), 0, 0.15) << samples << ' ' << aspect;
        }
}

TEST(GridLadder, ClimbsInEvenStepsToTheCap) {
    const std::vector<GridSize> fine = grid_ladder({257, 257}, false);
    EXPECT_EQ(fine.size(), 128U);  // 3, 5, ..., 257
    EXPECT_EQ(fine.front(), (GridSize{3, 3}));
    const std::vector<GridSize> coarse = grid_ladder({513, 1025}, true);
    EXPECT_EQ(coarse.back(), (GridSize{513, 1025}));
    for (std::size_t k = 0; k + 1 < coarse.size(); ++k) {
        EXPECT_LT(side_of(coarse[k]), side_of(coarse[k + 1]));
        EXPECT_EQ(coarse[k].rows % 2, 1U);
        EXPECT_EQ(coarse[k].cols % 2, 1U);
        if (coarse[k].rows > 65) { EXPECT_LT(side_of(coarse[k + 1]), 1.035 * side_of(coarse[k])); }
    }
    // 2..128 by 2, to 256 by 4, to 512 by 8, to 1024 by 16.
    EXPECT_EQ(coarse.size(), 64U + 32U + 32U + 32U);
    EXPECT_EQ(grid_ladder({4, 6}, true).back(), (GridSize{4, 6}));  // a cap with odd intervals is still the cap
}

TEST(SmallestThatHolds, FindsTheCrossingOfAnyPowerWithFewMeasurements) {
    const std::vector<GridSize> ladder = grid_ladder({2049, 2049}, true);
    for (const double power : {1.0, 1.4, 2.0, 2.9})
        for (const double wanted : {7.0, 40.0, 66.0, 130.0, 300.0, 1500.0}) {
            const auto error = [&](std::size_t k) { return std::pow(side_of(ladder[k]), -power); };
            const double asked = std::pow(wanted, -power);
            const SizeSearch search = smallest_that_holds(ladder, asked, first_65(ladder), error);
            expect_bracket(search, asked);
            EXPECT_GE(side_of(ladder[*search.found]), wanted);
            EXPECT_LE(search.trials.size(), 7U) << power << ' ' << wanted;
        }
}

TEST(SmallestThatHolds, CopesWithNoise) {
    const std::vector<GridSize> ladder = grid_ladder({2049, 2049}, true);
    const auto error = [&](std::size_t k) {  // up to 15 % off the square law, by a fixed pattern
        return std::pow(side_of(ladder[k]), -2) * (1 + 0.15 * std::sin(12.9898 * static_cast<double>(k)));
    };
    for (const double wanted : {30.0, 100.0, 250.0, 700.0}) {
        const SizeSearch search = smallest_that_holds(ladder, std::pow(wanted, -2), first_65(ladder), error);
        expect_bracket(search, std::pow(wanted, -2));
        EXPECT_NEAR(side_of(ladder[*search.found]) / wanted, 1, 0.12);
        EXPECT_LE(search.trials.size(), 10U);
    }
}

TEST(SmallestThatHolds, TakesTheFirstGridIfItHolds) {
    const std::vector<GridSize> ladder = grid_ladder({257, 257}, true);
    const SizeSearch search = smallest_that_holds(ladder, 0.1, first_65(ladder), [](std::size_t) { return 0.0; });
    EXPECT_EQ(search.found, 0U);
    EXPECT_LE(search.trials.size(), 6U);
}

TEST(SmallestThatHolds, MeasuresTheCapBeforeItSaysNo) {
    const std::vector<GridSize> ladder = grid_ladder({129, 129}, true);
    const auto error = [&](std::size_t k) { return std::pow(side_of(ladder[k]), -2); };
    const SizeSearch search = smallest_that_holds(ladder, std::pow(131, -2), first_65(ladder), error);
    EXPECT_FALSE(search.found);
    EXPECT_FALSE(search.given_up);
    EXPECT_EQ(search.trials.back().step, ladder.size() - 1);
}

TEST(SmallestThatHolds, GivesUpWhereTheErrorStaysPut) {
    const std::vector<GridSize> ladder = grid_ladder({2049, 2049}, true);
    std::size_t finest = 0;
    const SizeSearch search = smallest_that_holds(ladder, 0.01, first_65(ladder), [&](std::size_t k) {
        finest = std::max(finest, k);
        return 1.0;
    });
    EXPECT_FALSE(search.found);
    EXPECT_TRUE(search.given_up);
    EXPECT_LE(ladder[finest].rows, 513U);  // no million samples for an error that does not fall
}

TEST(SmallestThatHolds, SmallGridsWithoutAMapAreTooSmall) {
    const std::vector<GridSize> ladder = grid_ladder({513, 513}, true);
    const auto error = [&](std::size_t k) {
        return ladder[k].rows < 100 ? kInfinity : std::pow(side_of(ladder[k]), -2);
    };
    const SizeSearch search = smallest_that_holds(ladder, 1e-3, first_65(ladder), error);  // 32 a side would do
    expect_bracket(search, 1e-3);
    EXPECT_EQ(ladder[*search.found].rows, 101U);
}

TEST(SmallestThatHolds, StopsWhereNoGridHasAMap) {
    const std::vector<GridSize> ladder = grid_ladder({2049, 2049}, true);
    const SizeSearch search = smallest_that_holds(ladder, 1, first_65(ladder), [](std::size_t) { return kInfinity; });
    EXPECT_FALSE(search.found);
    EXPECT_LE(search.trials.size(), 3U);
}

TEST(LargestThatFits, FindsTheLastGridWithinTheBudget) {
    const std::vector<GridSize> ladder = grid_ladder({2049, 2049}, false);
    const auto bytes = [&](std::size_t k) {  // 30 bytes a sample in pages of 4096, and 20 pages of other things
        const double data = 30 * side_of(ladder[k]) * side_of(ladder[k]);
        return 4096 * (20 + std::ceil(data / 4096));
    };
    for (const double budget : {90e3, 262144.0, 1e6, 20e6}) {
        const SizeSearch search = largest_that_fits(ladder, budget, first_65(ladder), bytes);
        ASSERT_TRUE(search.found);
        EXPECT_LE(bytes(*search.found), budget);
        EXPECT_GT(bytes(*search.found + 1), budget);
        EXPECT_LE(search.trials.size(), 6U);
    }
    EXPECT_FALSE(largest_that_fits(ladder, 80e3, first_65(ladder), bytes).found);
    const SizeSearch all = largest_that_fits(ladder, 1e12, first_65(ladder), bytes);
    EXPECT_EQ(all.found, ladder.size() - 1);
}

TEST(ChooseAspect, FindsTheBestOfBothDirections) {
    for (const int best : {-4, -3, -1, 0, 2, 4}) {
        const auto measure = [&](GridSize size) {
            const double step = 2 * std::log2((size.rows - 1.0) / (size.cols - 1.0));
            return AspectTrial{size, 1 + 0.1 * std::abs(step - best), 0};
        };
        const AspectChoice choice = choose_aspect(4225, measure);
        EXPECT_NEAR(choice.aspect, std::pow(2.0, 0.5 * best), 1e-12) << best;
        EXPECT_LE(choice.trials.size(), 6U);
    }
}

TEST(ChooseAspect, StaysSquareForAPercent) {
    const AspectChoice choice = choose_aspect(4225, [](GridSize size) {
        return AspectTrial{size, size.rows > size.cols ? 0.99 : 1.0, 0};
    });
    EXPECT_EQ(choice.aspect, 1);
}

TEST(ChooseAspect, GoesAsFarAsItIsAskedAndNoFarther) {
    const auto longer_is_better = [](GridSize size) {
        const double aspect = (size.rows - 1.0) / (size.cols - 1.0);
        return AspectTrial{size, aspect >= 1 ? 1 / aspect : 10.0, 0};
    };
    EXPECT_NEAR(choose_aspect(4225, longer_is_better).aspect, 4, 1e-12);
    const AspectChoice far = choose_aspect(4225, longer_is_better, {.longest = 8});
    EXPECT_NEAR(far.aspect, 16, 1e-12);
    EXPECT_LT(far.rms, 0.07);
    EXPECT_EQ(far.trials.size(), 7U) << "1:1, 1:2, 2:1, 4:1, 8:1, 16:1 and the neighbour of the last";
}

TEST(ChooseAspect, FindsWhatOnlyTheFirstStepsReach) {
    // Errors grow from 1:1 on before they fall. From a first step that was too far the search goes back.
    for (const int best : {-9, -5, 6, 11}) {
        const auto measure = [&](GridSize size) {
            const double step = 2 * std::log2((size.rows - 1.0) / (size.cols - 1.0));
            return AspectTrial{size,
                               std::abs(step) < 3 ? 1.0 + 0.1 * std::abs(step) : 0.5 + 0.05 * std::abs(step - best), 0};
        };
        const AspectChoice choice = choose_aspect(66049, measure, {.longest = 12, .first = 8});
        EXPECT_NEAR(choice.aspect, std::pow(2.0, 0.5 * best), 1e-12) << best;
        EXPECT_LE(choice.trials.size(), 9U);
        EXPECT_EQ(choose_aspect(66049, measure, {.longest = 12}).aspect, 1);
    }
}

TEST(ChooseAspect, ThreeTrialsTellWhereOnlyTheFirstAreAsked) {
    const auto square_is_best = [](GridSize size) { return AspectTrial{size, size.rows == size.cols ? 1.0 : 2.0, 0}; };
    EXPECT_EQ(choose_aspect(4225, square_is_best, {.longest = 12, .first = 8}).trials.size(), 5U);
    EXPECT_EQ(choose_aspect(4225, square_is_best, {.longest = 12, .first = 8, .near = false}).trials.size(), 3U);
}

TEST(EvenGridOf, HasIntervalsThatEightDivides) {
    EXPECT_EQ(even_grid_of(257 * 257, 1), (GridSize{257, 257}));
    EXPECT_EQ(even_grid_of(257 * 257, 2), (GridSize{369, 177}));
    EXPECT_EQ(even_grid_of(257 * 257, 0.5), (GridSize{177, 369}));
    EXPECT_EQ(even_grid_of(257 * 257, 8), (GridSize{737, 89}));
    EXPECT_EQ(even_grid_of(4225, 16), grid_of(4225, 16)) << "too small";
    for (const double aspect : {1 / 11.0, 0.3, 0.7, 1.4, 2.8, 5.6, 11.0}) {
        const GridSize size = even_grid_of(257 * 257, aspect);
        EXPECT_EQ((size.rows - 1) % 8 + (size.cols - 1) % 8, 0U);
        EXPECT_LE(size.rows * size.cols, 257U * 257);
        EXPECT_GE(size.rows * size.cols, 257U * 257 * 9 / 10);
        EXPECT_NEAR(std::log((size.rows - 1.0) / (size.cols - 1.0) / aspect), 0, 0.25);
    }
}

TEST(ChooseAspect, AFreeChartHasItsOwn) {
    const AspectChoice choice = choose_aspect(4225, [](GridSize size) {
        return AspectTrial{size, size.rows > size.cols ? 0.7 : 1.0, 3.0};
    });
    EXPECT_EQ(choice.aspect, 3.0);
    EXPECT_EQ(choice.trials.size(), 2U);
}

TEST(ChooseAspect, AShapeWithoutAMapLoses) {
    const AspectChoice choice = choose_aspect(4225, [](GridSize size) {
        return AspectTrial{size, size.rows < 2 * size.cols - 20 ? kInfinity : 1.0, 0};
    });
    EXPECT_NEAR(choice.aspect, 2.0, 1e-12);
}

}  // namespace
}  // namespace dgm::bake
