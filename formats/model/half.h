// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/half.h
// IEEE 754 binary16, by the compiler's own type (round to nearest even).
#pragma once
#include <bit>
#include <cstdint>

namespace dgm::model {

#if defined(__clang__) && __clang_major__ < 15
using Half = __fp16;  // it has _Float16 on fewer processors; this one converts alike
#else
__extension__ using Half = _Float16;
#endif

[[nodiscard]] inline std::uint16_t half_bits(float value) { return std::bit_cast<std::uint16_t>(static_cast<Half>(value)); }
[[nodiscard]] inline float half_value(std::uint16_t bits) { return static_cast<float>(std::bit_cast<Half>(bits)); }

inline constexpr double kHalfMax = 65504.0;
inline constexpr double kHalfMinNormal = 6.103515625e-05;

}  // namespace dgm::model
