// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/half.h
// IEEE 754 binary16, by the compiler's own type (round to nearest even).
#pragma once
#include <cstdint>
#include <cstring>

namespace dgm::model {

#if (defined(__clang__) && __clang_major__ < 15) || (defined(__aarch64__) && !defined(__clang__) && __GNUC__ < 13)
using Half = __fp16;  // they have _Float16 on fewer processors, or in C alone; converts alike
#else
__extension__ using Half = _Float16;
#endif

// By memcpy: __fp16 cannot be passed to std::bit_cast.
[[nodiscard]] inline std::uint16_t half_bits(float value) {
    const Half half = static_cast<Half>(value);
    std::uint16_t bits;
    std::memcpy(&bits, &half, sizeof bits);
    return bits;
}
[[nodiscard]] inline float half_value(std::uint16_t bits) {
    Half half;
    std::memcpy(&half, &bits, sizeof half);
    return static_cast<float>(half);
}

inline constexpr double kHalfMax = 65504.0;
inline constexpr double kHalfMinNormal = 6.103515625e-05;

}  // namespace dgm::model
