// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/compare.h"

#include <gtest/gtest.h>

#include "model/error.h"
#include "tables.h"

namespace dgm::bench {
namespace {

using test::run_of;
using test::times;
using Lines = std::vector<std::string>;

TEST(Compare, TellsFasterSlowerBetterWorse) {
    const bench::Run then = run_of({{{"a", exactly(1), times({4, 4, 4})}}, {{"b", exactly(1), times({1, 1, 1})}}});
    const bench::Run now = run_of({{{"a", exactly(2), times({1, 1, 1})}}, {{"b", exactly(0.5), times({3, 3, 3})}}});
    EXPECT_EQ(compare_runs(now, then),
              (Lines{"faster: a CPU: 4.00 -> 1.00 s (0.25x, 0.25 to 0.26)",
                     "slower: b CPU: 1.00 -> 3.00 s (3.00x, 2.94 to 3.06)", "worse: a rms: 1.00 -> 2.00 %",
                     "better: b rms: 1.00 -> 0.500 %",
                     "4 changed; 0 within the noise; 0 taken fewer than 3 times, so nothing is said; 0 points in one "
                     "run only"}));
}

TEST(Compare, SaysNothingOfNoiseAndOfSingleRuns) {
    const bench::Run then = run_of({{{"a", exactly(1), times({4, 5, 6})}}, {{"b", exactly(1), times({1})}}});
    const bench::Run now = run_of({{{"a", exactly(1.005), times({5, 6, 7})}}, {{"b", exactly(1), times({9, 9, 9})}}});
    EXPECT_EQ(compare_runs(now, then),
              (Lines{"0 changed; 3 within the noise; 1 taken fewer than 3 times, so nothing is said; 0 points in one "
                     "run only"}));
}

TEST(Compare, OtherPointsAndOtherMachinesAreNotCompared) {
    bench::Run then = run_of({{{"a", exactly(1), times({4, 4, 4})}}, {{"gone", exactly(1), times({1, 1, 1})}}});
    then.machine[0].second = "slide rule";
    const bench::Run now = run_of({{{"a", exactly(1), times({1, 1, 1})}}, {{"new", exactly(1), times({1, 1, 1})}}});
    EXPECT_EQ(compare_runs(now, then),
              (Lines{"1 times not compared: they come from another machine or compiler",
                     "0 changed; 1 within the noise; 0 taken fewer than 3 times, so nothing is said; 2 points in one "
                     "run only"}));
}

TEST(Compare, RefusesAnotherCommand) {
    bench::Run then = run_of({});
    then.command = "scale";
    EXPECT_THROW((void)compare_runs(run_of({}), then), model::Error);
}

}  // namespace
}  // namespace dgm::bench
