// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/render/colour_test.cpp
#include "render/colour.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace dgm::render {
namespace {

double luminance(model::Rgba8 c) {
    const Rgb l = linear(c);
    return 0.2126 * l.r + 0.7152 * l.g + 0.0722 * l.b;
}

TEST(Colour, EveryByteSurvivesTheWayThroughLinearLight) {
    for (int b = 0; b < 256; ++b) EXPECT_EQ(byte_from_linear(linear_from_byte(static_cast<std::uint8_t>(b))), b);
    EXPECT_NEAR(linear_from_byte(188), 0.5029, 1e-4);  // the standard's value
}

TEST(Colour, SequentialMapGetsLighterAtEveryStep) {
    for (int k = 1; k < 256; ++k)  // neighbours may round to the same bytes
        EXPECT_GE(luminance(sequential_colour(k / 255.0)), luminance(sequential_colour((k - 1) / 255.0))) << k;
    for (int k = 4; k < 256; ++k)
        EXPECT_GT(luminance(sequential_colour(k / 255.0)), luminance(sequential_colour((k - 4) / 255.0))) << k;
    EXPECT_LT(luminance(sequential_colour(0)), 0.05);
    EXPECT_GT(luminance(sequential_colour(1)), 0.6);
    EXPECT_EQ(sequential_colour(-3), sequential_colour(0));
    EXPECT_EQ(sequential_colour(7), sequential_colour(1));
}

TEST(Colour, DivergingMapIsBlueWhiteRed) {
    const auto low = diverging_colour(-1), zero = diverging_colour(0), high = diverging_colour(1);
    EXPECT_GT(low.b, low.r + 60);
    EXPECT_GT(high.r, high.b + 60);
    EXPECT_GT(zero.r, 235);
    EXPECT_NEAR(zero.r, zero.b, 4);
}

TEST(Colour, NotANumberIsMagenta) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(sequential_colour(nan), (model::Rgba8{255, 0, 255, 255}));
    EXPECT_EQ(diverging_colour(nan), (model::Rgba8{255, 0, 255, 255}));
}

}  // namespace
}  // namespace dgm::render
