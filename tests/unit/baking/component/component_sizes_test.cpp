// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/baking/component/component_sizes_test.cpp
// The shares of samples among components.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "baking/component/component_sizes.h"

namespace dgm::bake {
namespace {

std::uint64_t samples_of(const std::vector<GridSize>& sizes) {
    std::uint64_t sum = 0;
    for (const GridSize& size : sizes) sum += std::uint64_t{size.rows} * size.cols;
    return sum;
}

TEST(ComponentSizes, FewComponentsKeepTheirSpacing) {
    const std::vector<double> areas{0.25, 1, 0.0625, 1e-9};
    const std::vector<GridSize> full(4, GridSize{257, 129});
    const std::vector<GridSize> sizes = component_sizes(full, areas, 1);
    ASSERT_EQ(sizes.size(), 4u);
    EXPECT_EQ(sizes[0], (GridSize{129, 65}));
    EXPECT_EQ(sizes[1], (GridSize{257, 129}));
    EXPECT_EQ(sizes[2], (GridSize{65, 33}));
    EXPECT_EQ(sizes[3], (GridSize{17, 17}));
}

/// `count` equal components share `whole` grids of the largest's samples.
void expect_shared(std::size_t count, std::uint32_t side, double whole) {
    const std::vector<double> areas(count, 2.5);
    const std::vector<GridSize> full(count, GridSize{side, side});
    const std::vector<GridSize> sizes = component_sizes(full, areas, 3);
    EXPECT_EQ(sizes[3].rows, side);
    const double samples = static_cast<double>(samples_of(sizes)) / (side * side);
    EXPECT_LE(samples, whole) << count << " of " << side;
    EXPECT_GT(samples, 0.9 * whole) << count << " of " << side;
    for (std::size_t c = 0; c < count; ++c) EXPECT_EQ(sizes[c], c == 3 ? sizes[3] : sizes[0]) << count;
    EXPECT_EQ(sizes[0] == sizes[3], static_cast<double>(count) <= whole) << count << " of " << side;
}

TEST(ComponentSizes, ManyShareTenTimesTheLargest) {
    for (const std::size_t count : {10u, 11u, 100u}) expect_shared(count, 129, 10);
}

/// Seven of 257 x 257 are 462,343 samples, which ten of 217 x 217 would exceed.
TEST(ComponentSizes, LargeOnesShareSevenTimesTheLargest) {
    for (const std::size_t count : {7u, 8u, 100u, 1000u}) expect_shared(count, 257, 7);
    for (const std::size_t count : {9u, 10u, 100u}) expect_shared(count, 217, 460'000.0 / (217 * 217));
    for (const std::size_t count : {7u, 8u, 1000u}) expect_shared(count, 513, 7);
}

/// 1000 grids of 17 x 17 are more than 10 of 65 x 65 samples.
TEST(ComponentSizes, TheLeastGridsMayComeToMore) {
    const std::vector<double> areas(1000, 1);
    const std::vector<GridSize> sizes = component_sizes(std::vector<GridSize>(1000, GridSize{65, 65}), areas, 0);
    EXPECT_EQ(sizes[0].rows, 65u);
    for (std::size_t c = 1; c < sizes.size(); ++c) ASSERT_EQ(sizes[c].rows, 17u);
}

/// 10,000 grids of 17 x 17 are three million samples.
TEST(ComponentSizes, ThousandsHaveSmallerOnes) {
    for (const std::uint32_t side : {33u, 65u, 257u}) {
        const std::vector<double> areas(10'000, 1);
        const std::vector<GridSize> sizes =
            component_sizes(std::vector<GridSize>(areas.size(), GridSize{side, side}), areas, 0);
        EXPECT_EQ(sizes[0].rows, side);
        for (std::size_t c = 1; c < sizes.size(); ++c) ASSERT_EQ(sizes[c], (GridSize{11, 11}));
    }
}

}  // namespace
}  // namespace dgm::bake
