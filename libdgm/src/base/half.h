// SPDX-License-Identifier: MIT
// libdgm/src/base/half.h
// IEEE 754 binary16 from binary32, rounded to nearest, ties to even; beyond 65504 infinity.
#pragma once
#include <cstdint>

namespace dgm::detail {

[[nodiscard]] inline std::uint16_t to_half(float value) noexcept {
    const std::uint32_t bits = __builtin_bit_cast(std::uint32_t, value), sign = bits >> 16 & 0x8000u;
    const std::uint32_t size = bits & 0x7FFFFFFFu;
    if (size > 0x7F800000u) return static_cast<std::uint16_t>(sign | 0x7E00u);
    if (size >= 0x477FF000u) return static_cast<std::uint16_t>(sign | 0x7C00u);
    if (size < 0x38800000u) {  // below 2^-14: the sum's last bit is worth 2^-24
        const float sum = __builtin_bit_cast(float, size) + 0.5f;
        return static_cast<std::uint16_t>(sign | (__builtin_bit_cast(std::uint32_t, sum) - 0x3F000000u));
    }
    const std::uint32_t odd = size >> 13 & 1u;
    return static_cast<std::uint16_t>(sign | ((size - 0x38000000u + 0xFFFu + odd) >> 13));
}

}  // namespace dgm::detail
