// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/baking/chart_effort_test.cpp
// The work of an asset is bounded, however many charts it has.
#include "baking/chart_effort.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/fit/fit.h"

namespace dgm::bake {
namespace {

TEST(ChartEffort, FewChartsHaveAllOfIt) {
    for (const std::size_t charts : {1u, 2u, 4u, 10u}) {
        const ChartEffort effort = chart_effort(charts, static_cast<double>(charts));
        EXPECT_EQ(effort.trial_samples, kTrialSamples);
        EXPECT_EQ(effort.measured_samples, kLeastMeasured);
        EXPECT_EQ(effort.points_of_small, kPointsOfSmall);
        EXPECT_EQ(effort.rounds, 1);
        const FitOptions fit = with_effort(l2_fit(), effort);
        EXPECT_EQ(fit.rounds, l2_fit().rounds);
        EXPECT_EQ(fit.snaps, l2_fit().snaps);
    }
    EXPECT_EQ(chart_effort(4, 4).patch_effort, kPatchEffort);
}

TEST(ChartEffort, ManySmallPartsOfALargeOneKeepTheirRounds) {
    EXPECT_EQ(chart_effort(1000, 4).rounds, 1);
    EXPECT_NEAR(chart_effort(1000, 7).rounds, 4.0 / 7, 1e-9);
}

TEST(ChartEffort, TheWorkOfAllIsBounded) {
    for (std::size_t charts = 1; charts <= 20'000; charts = charts * 3 / 2 + 1) {
        const ChartEffort effort = chart_effort(charts, 10);
        // Beyond these the least of each counts: a hundredth, and a tenth.
        EXPECT_LE(charts * effort.trial_samples, std::max<std::uint64_t>(50 * kTrialSamples, charts * 200));
        EXPECT_LE(charts * effort.measured_samples, std::max<std::uint64_t>(500 * kLeastMeasured, charts * 200));
        EXPECT_LE(charts * effort.points_of_small, std::max<std::uint64_t>(20 * kPointsOfSmall, charts));
        EXPECT_LE(charts * effort.patch_effort, std::max<std::uint64_t>(4 * kPatchEffort, charts * 10'000));
        // Samples times rounds.
        if (charts >= 20) { EXPECT_LE(10 * effort.rounds, 5.01); }
    }
    EXPECT_EQ(with_effort(l2_fit(), chart_effort(20, 10)).rounds, 6);
    EXPECT_EQ(with_effort(l2_fit(), chart_effort(20, 10)).snaps, l2_fit().snaps) << "a snap less costs 2 dB";
    EXPECT_EQ(with_effort(l2_fit(), chart_effort(20, 10)).worst_rounds, 0) << "nothing that was not asked for";
}

}  // namespace
}  // namespace dgm::bake
