// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "batch/batch_plan.h"

namespace dgm::bake {
namespace {

std::string name(int k) {
    return "organs/mesh" + std::to_string(k) + ".obj";
}

TEST(Shards, AreEven) {
    constexpr int kNames = 4000;
    std::array<int, 9> counts{};
    for (int k = 0; k < kNames; ++k) ++counts.at(shard_of(name(k), 8));
    EXPECT_EQ(counts[0], 0);  // they count from 1
    // 500 each, with a standard deviation of 21: five of them.
    for (unsigned s = 1; s <= 8; ++s) EXPECT_NEAR(counts.at(s), kNames / 8, 105) << s;
}

TEST(Shards, OneMoreTakesItsPartAndMovesNothingElse) {
    int moved = 0;
    for (int k = 0; k < 1000; ++k) {
        const unsigned before = shard_of(name(k), 4), after = shard_of(name(k), 5);
        if (before == after) continue;
        EXPECT_EQ(after, 5U);
        ++moved;
    }
    EXPECT_NEAR(moved, 200, 65);
    EXPECT_EQ(shard_of("anything", 1), 1U);
}

TEST(Shards, KeepTheOrderOfThePlan) {
    BatchPlan plan;
    for (int k = 0; k < 50; ++k) {
        plan.assets.emplace_back();
        plan.assets.back().name = name(k);
    }
    std::size_t together = 0;
    for (unsigned s = 1; s <= 3; ++s) {
        BatchPlan part = plan;
        keep_shard(part, {s, 3});
        together += part.assets.size();
        int last = -1;
        for (const PlannedAsset& asset : part.assets) {
            EXPECT_EQ(shard_of(asset.name, 3), s);
            const int number = std::stoi(asset.name.substr(std::string("organs/mesh").size()));
            EXPECT_GT(number, last);
            last = number;
        }
    }
    EXPECT_EQ(together, plan.assets.size());
}

}  // namespace
}  // namespace dgm::bake
