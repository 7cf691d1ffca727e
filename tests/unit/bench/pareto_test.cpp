// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/pareto.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dgm::bench {
namespace {

using Indices = std::vector<std::size_t>;

TEST(Pareto, KeepsWhatNothingBeats) {
    const std::vector<Cost> points{{4, 1}, {1, 4}, {2, 2}, {3, 3}, {2, 5}, {5, 1}};
    EXPECT_EQ(pareto_front(points), (Indices{1, 2, 0}));
}

TEST(Pareto, EqualPointsCountOnce) {
    const std::vector<Cost> points{{2, 2}, {2, 2}, {2, 3}};
    EXPECT_EQ(pareto_front(points), (Indices{0}));
}

TEST(Pareto, WhatIsNotFiniteTakesNoPart) {
    const std::vector<Cost> points{{std::nan(""), 0}, {1, std::nan("")}, {HUGE_VAL, 0}, {3, 3}};
    EXPECT_EQ(pareto_front(points), (Indices{3}));
    EXPECT_TRUE(pareto_front({}).empty());
}

}  // namespace
}  // namespace dgm::bench
