// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/edit/texture_padding_test.cpp
#include "edit/texture_padding.h"

#include <gtest/gtest.h>

#include <vector>

#include "geometry/layers/dilate.h"
#include "unit/render/sample_chart.h"

namespace dgm::edit {
namespace {

TEST(NearestCovered, IsTheNearestInStepsAndItselfWhereCovered) {
    std::vector<char> covered(25, 0);
    covered[6] = covered[18] = 1;  // (1, 1) and (3, 3) of 5 x 5
    const std::vector<std::uint32_t> from = bake::nearest_covered(covered, 5, 5);
    EXPECT_EQ(from[6], 6u);
    EXPECT_EQ(from[18], 18u);
    EXPECT_EQ(from[0], 6u);
    EXPECT_EQ(from[24], 18u);
    EXPECT_EQ(from[12], 6u);  // as near to both: the one that the search meets first
    EXPECT_EQ(bake::nearest_covered(std::vector<char>(4, 0), 2, 2), std::vector<std::uint32_t>(4, bake::kNone));
}

/// A free chart of 5 x 5 whose surface is the quad between (1, 1) and (2, 2), with a texture of a texel a sample.
model::Chart one_quad() {
    model::Chart chart;
    chart.rows = chart.cols = 5;
    chart.domain = model::Domain::kFree;
    std::vector<std::uint8_t> mask(25, 0);
    for (const std::size_t s : {6u, 7u, 11u, 12u}) mask[s] = 1;
    chart.layers.push_back(test::make_layer("mask", model::ElementType::kU8, {5, 5}, mask));
    chart.layers.push_back(
        test::make_layer("texture", model::ElementType::kU8, {5, 5, 4}, std::vector<std::uint8_t>(100, 10)));
    return chart;
}

TEST(TexturePadding, PaintReachesTheTexelsThatItsOwnColours) {
    model::Chart chart = one_quad();
    model::Layer& texture = *chart.find("texture");
    std::vector<char> changed(25, 0);
    changed[6] = 1;
    changed[2] = 1;  // beyond the surface, painted itself
    for (int c = 0; c < 4; ++c) {
        texture.bytes[4 * 6 + static_cast<std::size_t>(c)] = std::byte{200};
        texture.bytes[4 * 2 + static_cast<std::size_t>(c)] = std::byte{90};
    }
    const std::uint64_t count = pad_texture(chart, changed, texture);
    const auto red = [&](std::size_t t) { return std::to_integer<int>(texture.bytes[4 * t]); };
    EXPECT_EQ(count, 3u);
    for (const std::size_t t : {0u, 1u, 5u, 6u}) EXPECT_EQ(red(t), 200) << t;
    EXPECT_EQ(red(2), 90);
    for (const std::size_t t : {3u, 7u, 12u, 24u, 20u}) EXPECT_EQ(red(t), 10) << t;
}

}  // namespace
}  // namespace dgm::edit
