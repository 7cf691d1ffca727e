// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dgm::bench {
namespace {

TEST(Statistics, QuantilesAreLinearBetweenNeighbours) {
    EXPECT_DOUBLE_EQ(quantile({4, 1, 3, 2}, 0.5), 2.5);
    EXPECT_DOUBLE_EQ(quantile({4, 1, 3, 2}, 0), 1);
    EXPECT_DOUBLE_EQ(quantile({4, 1, 3, 2}, 1), 4);
    EXPECT_DOUBLE_EQ(quantile({10, 20}, 0.25), 12.5);
    EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

TEST(Statistics, SpreadIsStudentsIntervalOfLogarithms) {
    // Logarithms 0, 1, 2: s = 1, t(2) = 4.303, sqrt(2/3): half width 3.5134 around the median's logarithm 1.
    const Figure f = summarize(std::vector<double>{1, std::exp(2), std::exp(1)});
    EXPECT_NEAR(f.value, std::exp(1), 1e-12);
    EXPECT_NEAR(std::log(f.low), 1 - 3.51339, 1e-3);
    EXPECT_NEAR(std::log(f.high), 1 + 3.51339, 1e-3);
    EXPECT_EQ(f.repetitions, 3U);
}

TEST(Statistics, EqualTimesStillDifferByTwoPerCent) {
    const Figure f = summarize(std::vector<double>{3, 3, 3, 3});
    EXPECT_NEAR(f.high / f.value, std::exp(0.02), 1e-12);
}

TEST(Statistics, OneTimeHasNoSpread) {
    const Figure f = summarize(std::vector<double>{3});
    EXPECT_EQ(f.repetitions, 1U);
    EXPECT_EQ(f.low, 3);
    EXPECT_EQ(f.high, 3);
}

TEST(Statistics, AnotherRunFallsIntoTheSpread) {
    std::mt19937 random(7);
    std::lognormal_distribution<double> times(0, 0.1);
    const auto run = [&] {
        std::vector<double> sample(4);
        for (double& t : sample) t = times(random);
        return summarize(sample);
    };
    int inside = 0;
    for (int k = 0; k < 2000; ++k) {
        const Figure first = run(), second = run();
        inside += second.value > first.low && second.value < first.high ? 1 : 0;
    }
    EXPECT_GT(inside, 2000 * 0.92);  // medians scatter a little more than the means Student speaks of
}

TEST(Statistics, NoRatioFromOneRun) {
    const Figure once = summarize(std::vector<double>{2}), twice = summarize(std::vector<double>{2, 2});
    const Figure enough = summarize(std::vector<double>{1, 1, 1});
    EXPECT_FALSE(ratio(once, enough));
    EXPECT_FALSE(ratio(enough, once));
    EXPECT_FALSE(ratio(twice, enough));
    EXPECT_FALSE(ratio(exactly(0), exactly(1)));
    EXPECT_TRUE(ratio(exactly(2), exactly(1)));
}

TEST(Statistics, RatiosKnowNoise) {
    const Figure calm = summarize(std::vector<double>{1, 1, 1}), slow = summarize(std::vector<double>{2, 2, 2});
    const Figure wild = summarize(std::vector<double>{1, 3, 2});
    ASSERT_TRUE(ratio(slow, calm));
    EXPECT_DOUBLE_EQ(ratio(slow, calm)->value, 2);
    EXPECT_TRUE(ratio(slow, calm)->beyond_noise());
    EXPECT_FALSE(ratio(wild, calm)->beyond_noise());
    EXPECT_FALSE(ratio(calm, calm)->beyond_noise());
}

TEST(Statistics, FitsPowers) {
    std::vector<double> x, y;
    for (int k = 1; k < 6; ++k) {
        x.push_back(std::pow(10, k));
        y.push_back(3 * std::pow(x.back(), 1.25));
    }
    const auto law = fit_power_law(x, y);
    ASSERT_TRUE(law);
    EXPECT_NEAR(law->exponent, 1.25, 1e-12);
    EXPECT_NEAR(law->error, 0, 1e-7);
    y[2] *= 2;
    EXPECT_GT(fit_power_law(x, y)->error, 0.01);
    EXPECT_FALSE(fit_power_law(std::vector<double>{1, 2}, std::vector<double>{1, 2}));
    EXPECT_FALSE(fit_power_law(std::vector<double>{5, 5, 5}, std::vector<double>{1, 2, 3}));
    EXPECT_FALSE(fit_power_law(std::vector<double>{1, 2, 3}, std::vector<double>{1, 0, 3}));
}

}  // namespace
}  // namespace dgm::bench
