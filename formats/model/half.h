// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/half.h
// IEEE 754 binary16 by integers: the types that compilers have for it call functions that some of them lack.
#pragma once
#include <bit>
#include <cstdint>

namespace dgm::model {

inline constexpr std::uint32_t kHalfSign = 0x8000, kHalfInfinity = 0x7C00, kHalfQuiet = 0x0200;
inline constexpr std::uint32_t kHalfRebias = (127 - 15) << 23;  // of exponents, in the bits of a float

/// Rounds to nearest, ties to even; from 65520 on to infinity. What is not a number stays so and becomes quiet.
[[nodiscard]] inline std::uint16_t half_bits(float value) {
    constexpr std::uint32_t kFloatInfinity = 0x7F800000, kOverflow = 0x477FF000, kLeastNormal = 0x38800000;
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const std::uint32_t sign = bits >> 16 & kHalfSign, size = bits & ~(kHalfSign << 16);
    const auto made = [&](std::uint32_t half) { return static_cast<std::uint16_t>(sign | half); };
    if (size > kFloatInfinity) return made(kHalfInfinity | kHalfQuiet | (size >> 13 & 0x3FF));
    if (size >= kOverflow) return made(kHalfInfinity);
    if (size < kLeastNormal) {  // floats from 0.5 to 1 lie as far apart as the least halves: the sum is rounded alike
        const float sum = std::bit_cast<float>(size) + 0.5f;
        return made(std::bit_cast<std::uint32_t>(sum) - std::bit_cast<std::uint32_t>(0.5f));
    }
    return made((size - kHalfRebias + 0xFFF + (size >> 13 & 1)) >> 13);
}

/// Exact. What is not a number keeps its bits and becomes quiet.
[[nodiscard]] inline float half_value(std::uint16_t bits) {
    constexpr float kLeast = 0x1p-24f;
    const std::uint32_t sign = (bits & kHalfSign) << 16, size = bits & ~kHalfSign;
    const auto made = [&](std::uint32_t magnitude) { return std::bit_cast<float>(sign | magnitude); };
    if (size > kHalfInfinity) return made(0x7F800000 | (size | kHalfQuiet) << 13);
    if (size == kHalfInfinity) return made(0x7F800000);
    if (size < 0x400) return made(std::bit_cast<std::uint32_t>(static_cast<float>(size) * kLeast));
    return made((size << 13) + kHalfRebias);
}

inline constexpr double kHalfMax = 65504.0;
inline constexpr double kHalfMinNormal = 6.103515625e-05;

}  // namespace dgm::model
