// SPDX-License-Identifier: GPL-3.0-or-later
#include "baking/search/grid_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "baking/search/size_search.h"
#include "batch/report_text.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

constexpr double kDiagonal = 50;

/// rms 100/samples, twice that at most.
GridTrial square_law(GridSize size) {
    const double rms = 100.0 / (static_cast<double>(size.rows) * size.cols);
    return {size.rows, size.cols, rms, 2 * rms, 0, "", 0};
}

TEST(SearchByError, KeepsTheAnswerAndTellsOfTheNextSmallerGrid) {
    std::vector<GridSize> kept;
    const GridTries tries{square_law, [&](GridSize size) { kept.push_back(size); }};
    // 0.02 % of 50 is 0.01: 100 a side, and 1 % in hand: 100.5.
    const GridSearch search =
        search_by_error({0.02, true, ErrorKind::kRms}, kDiagonal, grid_ladder({513, 513}, true), 65, tries);
    EXPECT_EQ(search.goal, SearchGoal::kMaxError);
    EXPECT_EQ(search.kind, ErrorKind::kRms);
    EXPECT_DOUBLE_EQ(search.asked, 0.01);
    EXPECT_DOUBLE_EQ(search.asked_percent, 0.02);
    EXPECT_EQ(search.rows, 101U);
    EXPECT_EQ(kept.back(), (GridSize{101, 101}));
    ASSERT_TRUE(search.next);
    EXPECT_EQ(search.next->rows, 99U);
    EXPECT_EQ(search.next->outcome, "does not hold");
    EXPECT_DOUBLE_EQ(search.next->rms, 100.0 / (99 * 99));
    EXPECT_EQ(search_story(search, kDiagonal),
              "asked for rms 0.02 % (0.01 units): 101x101 reaches 0 % (0 units); the next smaller grid, 99x99, would "
              "have given 0.02041 % (0.0102 units)");
}

TEST(SearchByError, UnitsAndTheLargestDistance) {
    const GridTries tries{square_law, [](GridSize) {}};
    // 200/s^2 <= 0.02/1.05: s >= 102.5
    const GridSearch search =
        search_by_error({0.02, false, ErrorKind::kHausdorff}, kDiagonal, grid_ladder({513, 513}, true), 65, tries);
    EXPECT_EQ(search.kind, ErrorKind::kHausdorff);
    EXPECT_DOUBLE_EQ(search.asked, 0.02);
    EXPECT_EQ(search.rows, 103U);
}

TEST(SearchByError, SaysHowFarItGot) {
    const GridTries tries{square_law, [](GridSize) { FAIL() << "nothing holds"; }};
    try {
        (void)search_by_error({0.01, true, ErrorKind::kRms}, kDiagonal, grid_ladder({129, 129}, true), 65, tries);
        FAIL();
    } catch (const model::Error& e) {
        EXPECT_EQ(&e.code(), &model::codes::kErrorNotReached);
        EXPECT_STREQ(e.what(),
                     "rms 0.005 (0.01 % of the diagonal) was asked for; 129x129 reaches 0.00601 (0.012 %)\n"
                     "that is the largest grid allowed");
    }
}

TEST(SearchByError, ASmallGridsFailureIsATrialAndOthersAreNot) {
    const auto no_map_below = [](std::uint32_t side, const model::Code& code) {
        return GridTries{[side, &code](GridSize size) -> Attempt<GridTrial> {
                             if (size.rows < side) return model::Error(code, "no room for the cut");
                             return square_law(size);
                         },
                         [](GridSize) {}};
    };
    const std::vector<GridSize> ladder = grid_ladder({513, 513}, true);
    const ErrorGoal goal{1, true, ErrorKind::kRms};
    const GridSearch search =
        search_by_error(goal, kDiagonal, ladder, 65, no_map_below(21, model::codes::kGridTooSmall));
    EXPECT_EQ(search.rows, 21U);
    ASSERT_TRUE(search.next);
    EXPECT_EQ(search.next->outcome, "no room for the cut");
    const auto code_of = [&](const GridTries& tries) {
        try {
            (void)search_by_error(goal, kDiagonal, ladder, 65, tries);
        } catch (const model::Error& e) { return e.code().number; }
        return 0;
    };
    EXPECT_EQ(code_of(no_map_below(9999, model::codes::kMapInvalid)), model::codes::kMapInvalid.number);
    EXPECT_EQ(code_of(no_map_below(9999, model::codes::kInterrupted)), model::codes::kInterrupted.number);
    EXPECT_EQ(code_of(no_map_below(9999, model::codes::kMethodUnsuited)), model::codes::kMethodUnsuited.number);
}

TEST(SearchByBudget, TakesTheLargestThatFits) {
    const GridTries tries{[](GridSize size) {
                              GridTrial trial{size.rows, size.cols, NAN, NAN, 0, "", 0};
                              trial.bytes = 8192 + std::uint64_t{20} * size.rows * size.cols;
                              return trial;
                          },
                          [](GridSize) {}};
    const std::vector<GridSize> ladder = grid_ladder({513, 513}, false);
    const GridSearch search = search_by_budget(262144, ladder, tries);  // (262144 - 8192) / 20 = 12697.6, 112.7 a side
    EXPECT_EQ(search.goal, SearchGoal::kBudget);
    EXPECT_EQ(search.rows, 111U);
    ASSERT_TRUE(search.next);
    EXPECT_EQ(search.next->rows, 113U);
    EXPECT_EQ(search.next->bytes, 8192U + 20 * 113 * 113);
    try {
        (void)search_by_budget(8200, ladder, tries);
        FAIL();
    } catch (const model::Error& e) {
        EXPECT_EQ(&e.code(), &model::codes::kBudgetTooSmall);
        EXPECT_STREQ(e.what(), "8200 bytes were asked for; the smallest file, of 3x3, takes 8372");
    }
}

}  // namespace
}  // namespace dgm::bake
