// SPDX-License-Identifier: GPL-3.0-or-later
// cli/page/grid_codes.h
// Positions as deflate likes them: what is left when each is guessed from three neighbours.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace dgm::page {

/// An unsigned number that stands for a signed one, its sign moved to the lowest bit: 0, -1, 1, -2, ... become
/// 0, 1, 2, 3, ...
template <class T>
[[nodiscard]] constexpr T sign_last(T number) {
    const bool negative = (number >> (8 * sizeof(T) - 1) & 1) != 0;
    return static_cast<T>(static_cast<T>(number << 1) ^ (negative ? static_cast<T>(~T{0}) : T{0}));
}

/// Replaces rows x cols x 3 codes of 16 bits, little-endian, by what the parallelogram rule leaves, modulo 2^16:
///     r(i, j) = q(i, j) - q(i, j-1) - q(i-1, j) + q(i-1, j-1),   with 0 outside,
/// by sign_last(), all low bytes first, then all high ones.
/// A smooth surface takes half the space that way. web/module.js turns it back.
void code_grid(std::span<std::byte> bytes, std::uint32_t rows, std::uint32_t cols);

}  // namespace dgm::page
