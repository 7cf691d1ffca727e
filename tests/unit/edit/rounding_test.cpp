// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/edit/rounding_test.cpp
#include "edit/rounding.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace dgm::edit {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Rounding, ExactNumbersArePaintedByOneBit) {
    EXPECT_TRUE(is_untouched(0.1f, 0.1f, Rounding::exact()));
    EXPECT_FALSE(is_untouched(0.1f, std::nextafter(0.1f, 1.0f), Rounding::exact()));
    EXPECT_TRUE(is_untouched(0.0, -0.0, Rounding::exact()));
}

TEST(Rounding, NoNumberIsOnlyWhatItWas) {
    for (const Rounding& rounding : {Rounding::exact(), Rounding::half(), Rounding::codes(0, 1, 255)}) {
        EXPECT_TRUE(is_untouched(kNan, kNan, rounding));
        EXPECT_FALSE(is_untouched(0.5, kNan, rounding));
        EXPECT_FALSE(is_untouched(kNan, 0.5, rounding));
    }
}

TEST(Rounding, AHalfOfTheNumberIsUntouchedAndTheNextHalfIsNot) {
    const float original = 0.1f;
    const std::uint16_t bits = model::half_bits(original);
    EXPECT_TRUE(is_untouched(original, model::half_value(bits), Rounding::half()));
    EXPECT_FALSE(is_untouched(original, model::half_value(static_cast<std::uint16_t>(bits + 1)), Rounding::half()));
    EXPECT_FALSE(is_untouched(original, model::half_value(static_cast<std::uint16_t>(bits - 1)), Rounding::half()));
}

TEST(Rounding, EveryNumberKeepsItsOwnCodeAndNoOther) {
    for (const unsigned steps : {255u, 65535u})
        for (const auto& [low, high] : {std::pair{0.0, 1.0}, std::pair{-3.5, 0.25}}) {
            const Rounding rounding = Rounding::codes(low, high, steps);
            for (unsigned k = 0; k <= 1000; ++k) {
                const double original = low + (high - low) * k / 1000;
                const double code = std::round((original - low) / (high - low) * steps);
                // As pictures are read: in single precision.
                const auto saved = [&](double c) {
                    return rounding.value_of(static_cast<double>(static_cast<float>(c) / static_cast<float>(steps)));
                };
                EXPECT_TRUE(is_untouched(original, saved(code), rounding)) << steps << ' ' << original;
                for (const double other : {code - 2, code + 2}) {
                    if (other < 0 || other > steps) continue;
                    EXPECT_FALSE(is_untouched(original, saved(other), rounding)) << original;
                }
            }
        }
}

TEST(Rounding, BeyondTheRangeTheLastCodeStands) {
    const Rounding rounding = Rounding::codes(0, 1, 255);
    EXPECT_TRUE(is_untouched(1.5, 1.0, rounding));
    EXPECT_FALSE(is_untouched(1.5, 0.9, rounding));
}

TEST(Rounding, CodesOfOneNumberPaintNothing) {
    EXPECT_TRUE(is_untouched(0.5, 0.5, Rounding::codes(0.5, 0.5, 255)));
}

TEST(Rounding, CodesStandForTheirRange) {
    EXPECT_DOUBLE_EQ(Rounding::codes(-2, 6, 255).value_of(0.25), 0.0);
    EXPECT_DOUBLE_EQ(Rounding::exact().value_of(0.25), 0.25);
}

}  // namespace
}  // namespace dgm::edit
