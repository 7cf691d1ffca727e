// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/model/half_test.cpp
// Halves by their definition: sign, exponent and mantissa, rounded to nearest with ties to even.
#include "model/half.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace dgm::model {
namespace {

double defined(std::uint16_t bits) {
    const int exponent = bits >> 10 & 31, mantissa = bits & 0x3FF;
    const double size = exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
    return (bits & 0x8000) != 0 ? -size : size;
}

TEST(Half, HasTheValueThatItsBitsDefineAndGoesBackToThem) {
    for (std::uint32_t k = 0; k < 0x10000; ++k) {
        const auto bits = static_cast<std::uint16_t>(k);
        if ((bits & 0x7C00) == 0x7C00) continue;
        ASSERT_EQ(half_value(bits), defined(bits)) << k;
        ASSERT_EQ(std::signbit(half_value(bits)), (bits & 0x8000) != 0) << k;
        ASSERT_EQ(half_bits(half_value(bits)), bits) << k;
    }
}

TEST(Half, RoundsToTheNearestAndTiesToEven) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const auto above = [](std::uint16_t bits) {  // the largest is followed by 65536 for this purpose
        return bits == 0x7BFF ? 65536.0 : defined(static_cast<std::uint16_t>(bits + 1));
    };
    for (std::uint16_t bits = 0; bits < 0x7C00; ++bits) {
        const auto next = static_cast<std::uint16_t>(bits + 1);
        const auto tie = static_cast<float>((defined(bits) + above(bits)) / 2);
        ASSERT_EQ(half_bits(tie), bits % 2 == 0 ? bits : next) << bits;
        ASSERT_EQ(half_bits(std::nextafter(tie, 0.0f)), bits) << bits;
        ASSERT_EQ(half_bits(-std::nextafter(tie, kInfinity)), next | 0x8000) << bits;
    }
}

TEST(Half, KeepsWhatIsNoNumberAndWhatIsTooLarge) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    EXPECT_EQ(half_bits(kInfinity), 0x7C00);
    EXPECT_EQ(half_bits(-3e38f), 0xFC00);
    EXPECT_EQ(half_bits(std::numeric_limits<float>::denorm_min()), 0);
    EXPECT_EQ(half_value(0xFC00), -kInfinity);
    EXPECT_TRUE(std::isnan(half_value(0x7C01)));
    EXPECT_EQ(half_bits(half_value(0xFE55)), 0xFE55);
}

}  // namespace
}  // namespace dgm::model
