// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/baking/component/component_loop_test.cpp
#include "baking/component/component_loop.h"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <vector>

namespace dgm::bake {
namespace {

TEST(ComponentLoop, WorksOnEachOnceAndTellsRisingSharesUpToAll) {
    std::vector<int> calls(100, 0);
    std::vector<double> told;
    const model::Progress progress{[&](std::string_view stage, double share) {
        EXPECT_EQ(stage, "fit");
        told.push_back(share);
    }};
    for_each_component(calls.size(), progress, [&](std::size_t k, const model::Progress& part) {
        part.update("fit", 0.5);
        part.update("fit", 0.25);  // a part that starts over does not take back its reports
        ++calls[k];
        part.update("fit", 1);
    });
    EXPECT_EQ(calls, std::vector<int>(100, 1));
    ASSERT_EQ(told.size(), 300u);
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
    EXPECT_NEAR(told.back(), 1, 1e-12);
}

TEST(ComponentLoop, ThrowsTheFailureOfTheLowestComponent) {
    for (int round = 0; round < 20; ++round) {
        std::vector<std::atomic<int>> calls(64);
        try {
            for_each_component(64, {}, [&](std::size_t k, const model::Progress&) {
                ++calls[k];
                if (k % 7 == 5) throw model::Error(model::codes::kMapInvalid, "component " + std::to_string(k));
            });
            ADD_FAILURE() << "nothing thrown";
        } catch (const model::Error& error) { EXPECT_STREQ(error.what(), "component 5"); }
        for (std::size_t k = 0; k <= 5; ++k) EXPECT_EQ(calls[k], 1);
    }
}

TEST(ComponentLoop, StopsWhenAskedTo) {
    const std::atomic<bool> stop{true};
    const model::Progress progress{{}, &stop};
    int finished = 0;
    try {
        for_each_component(8, progress, [&](std::size_t, const model::Progress& part) {
            part.update("fit", 0);
            ++finished;
        });
        ADD_FAILURE() << "nothing thrown";
    } catch (const model::Error& error) { EXPECT_EQ(error.code().number, model::codes::kInterrupted.number); }
    EXPECT_EQ(finished, 0);
}

}  // namespace
}  // namespace dgm::bake
