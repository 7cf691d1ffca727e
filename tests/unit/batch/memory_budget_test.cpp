// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/memory_budget.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <vector>

namespace dgm::bake {
namespace {

namespace fs = std::filesystem;

TEST(MemoryBudget, GrowsWithTheFileAndTheGrid) {
    const fs::path small = fs::temp_directory_path() / ("dgm-small-" + std::to_string(getpid()) + ".obj"),
                   large = fs::temp_directory_path() / ("dgm-large-" + std::to_string(getpid()) + ".obj");
    std::ofstream(small) << std::string(1000, ' ');
    std::ofstream(large) << std::string(10'000'000, ' ');
    BakeOptions options;
    const std::uint64_t usual = estimate_peak(small, options);
    EXPECT_GT(usual, std::uint64_t{32} << 20);
    EXPECT_GT(estimate_peak(large, options), usual + (std::uint64_t{100} << 20));
    options.size = {2049, 2049};
    EXPECT_GT(estimate_peak(small, options), usual + (std::uint64_t{1} << 30));
    options.auto_samples = 100;
    EXPECT_LT(estimate_peak(small, options), usual);
    EXPECT_EQ(estimate_peak("/there/is/no/such.obj", options), 0U);
    fs::remove(small);
    fs::remove(large);
}

TEST(MemoryBudget, AGridThatCannotFitIsRefusedWithTheLargestThatDoes) {
    constexpr std::uint64_t kLimit = std::uint64_t{8} << 30;
    BakeOptions options;
    options.size = {8193, 8193};
    const std::optional<model::Error> error = refuse_size(options, kLimit);
    ASSERT_TRUE(error);
    EXPECT_STREQ(error->what(),
                 "a grid of 8193x8193 takes about 134 GB of memory; 8192 MiB are enough for about 2061x2061");
    EXPECT_FALSE(refuse_size(options, 0));
    EXPECT_FALSE(refuse_size(options, std::uint64_t{200} << 30));
    options.size = {2061, 2061};
    EXPECT_FALSE(refuse_size(options, kLimit));
    options.size = {8193, 8193};
    options.max_error = ErrorGoal{};  // the largest grid tried, not the one asked for
    EXPECT_FALSE(refuse_size(options, kLimit));
}

TEST(MemoryBudget, SeesWhatAProcessHolds) {
    constexpr std::size_t kBytes = std::size_t{64} << 20;
    const std::uint64_t before = resident_memory(getpid());
    EXPECT_GT(before, 0U);
    const std::vector<char> held(kBytes, 'x');
    EXPECT_GT(resident_memory(getpid()) + (std::uint64_t{8} << 20), before + held.size());
    EXPECT_EQ(resident_memory(-1), 0U);
    EXPECT_GT(available_memory(), 0U);
}

}  // namespace
}  // namespace dgm::bake
