// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/cut_search/component_search_test.cpp
// How much is tried.
#include "geometry/cut_search/component_search.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace dgm::bake {
namespace {

TEST(ComponentSearch, TriesFewCutsWhileThereIsNoMap) {
    int tried = 0, last = 0;
    for (int limbs = 0; limbs <= 640; ++limbs) {
        if (!is_worth_a_trial(limbs)) continue;
        EXPECT_LE(4 * (limbs - last), std::max(limbs, 4)) << "a quarter more than are needed, at most";
        last = limbs;
        ++tried;
        if (limbs < 8) { EXPECT_EQ(tried, limbs + 1); }
        if (limbs == 40) { EXPECT_LE(tried, 20); }
    }
    EXPECT_EQ(last, 640);
    EXPECT_LE(tried, 60);
}

}  // namespace
}  // namespace dgm::bake
