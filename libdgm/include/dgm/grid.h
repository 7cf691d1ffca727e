// SPDX-License-Identifier: MIT
// libdgm/include/dgm/grid.h
// Defines the index rules of a chart's m x n grid once for the baker, the file tools and the runtime.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace dgm {

/// Flat index of sample (i, j): row i in 0..m-1 is at u = i / (m - 1), column j in 0..n-1 at v = j / (n - 1).
[[nodiscard]] constexpr std::size_t sample_index(std::size_t i, std::size_t j, std::size_t n) noexcept {
    return i * n + j;
}

/// Quads of a leaf tile in each direction.
inline constexpr std::uint32_t kTileQuads = 8;
/// Number of leaf tiles that cover `quads` quads in one direction; at least 1.
[[nodiscard]] constexpr std::uint32_t tile_count(std::uint32_t quads) noexcept {
    return quads == 0 ? 1 : (quads + kTileQuads - 1) / kTileQuads;
}

/// The two triangles of quad (i, j) of a grid with n columns, as flat sample indices, counter-clockwise in (u, v).
///
/// Diagonal 0 runs along (i, j)-(i+1, j+1), diagonal 1 along (i+1, j)-(i, j+1) (layer `diagonals`, formats/SPEC.md).
[[nodiscard]] constexpr std::array<std::array<std::uint32_t, 3>, 2> quad_triangles(std::uint32_t i, std::uint32_t j,
                                                                                   std::uint32_t n,
                                                                                   unsigned diagonal) noexcept {
    const std::uint32_t a = i * n + j, b = a + n, c = b + 1, d = a + 1;
    if (diagonal == 0) return {{{a, b, c}, {a, c, d}}};
    return {{{a, b, d}, {b, c, d}}};
}

}  // namespace dgm
