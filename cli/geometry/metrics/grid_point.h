// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/metrics/grid_point.h
// Finds the place of a point (u, v) of the grid: on a triangle of a quad, or among four texels of a layer.
#pragma once
#include <dgm/grid.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

namespace dgm::bake {

/// A point of the grid surface: three samples and their weights.
struct GridPoint {
    std::array<std::uint32_t, 3> sample{};
    std::array<double, 3> b{};
};

/// The triangle under row x in [0, m-1] and column y in [0, n-1]; `has_quad(i, j)` and `diagonal(i, j)` describe the
/// quads. A point on a grid line belongs to the quads on both sides, of which one may be missing.
template <class HasQuad, class Diagonal>
[[nodiscard]] std::optional<GridPoint> grid_point(double x, double y, std::uint32_t m, std::uint32_t n,
                                                  const HasQuad& has_quad, const Diagonal& diagonal) {
    const auto i0 = std::min(static_cast<std::uint32_t>(x), m - 2), j0 = std::min(static_cast<std::uint32_t>(y), n - 2);
    for (std::uint32_t back_i = 0; back_i < 2; ++back_i)
        for (std::uint32_t back_j = 0; back_j < 2; ++back_j) {
            if ((back_i == 1 && (x != i0 || i0 == 0)) || (back_j == 1 && (y != j0 || j0 == 0))) continue;
            const std::uint32_t i = i0 - back_i, j = j0 - back_j;
            if (!has_quad(i, j)) continue;
            const double s = x - i, t = y - j;
            const unsigned d = diagonal(i, j);
            const bool second = d == 0 ? t > s : s + t > 1;
            const std::array<std::uint32_t, 3> f = quad_triangles(i, j, n, d)[second];
            // (0,0) (1,0) (1,1) | (0,0) (1,1) (0,1)   or   (0,0) (1,0) (0,1) | (1,0) (1,1) (0,1)
            GridPoint p;
            p.sample = f;
            p.b = d == 0   ? second ? std::array{1 - t, s, t - s} : std::array{1 - s, s - t, t}
                    : second ? std::array{1 - t, s + t - 1, 1 - s}
                           : std::array{1 - s - t, s, t};
            return p;
        }
    return std::nullopt;
}

/// Four texels of a rows x cols layer and their weights.
struct TexelTaps {
    std::array<std::uint32_t, 4> texel{};
    std::array<double, 4> weight{};
};

/// Bilinear taps at row x in [0, rows-1] and column y in [0, cols-1]; rows, cols >= 1.
[[nodiscard]] inline TexelTaps texel_taps(double x, double y, std::uint32_t rows, std::uint32_t cols) {
    const auto axis = [](double at, std::uint32_t size, std::uint32_t& low, std::uint32_t& high) {
        low = std::min(static_cast<std::uint32_t>(std::max(at, 0.0)), size >= 2 ? size - 2 : 0u);
        high = std::min(low + 1, size - 1);
        return std::clamp(at - low, 0.0, 1.0);
    };
    std::uint32_t i0 = 0, i1 = 0, j0 = 0, j1 = 0;
    const double s = axis(x, rows, i0, i1), t = axis(y, cols, j0, j1);
    return {{i0 * cols + j0, i1 * cols + j0, i0 * cols + j1, i1 * cols + j1},
            {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t}};
}

}  // namespace dgm::bake
