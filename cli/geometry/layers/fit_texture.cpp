// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/fit_texture.cpp
#include <algorithm>
#include <cmath>

#include "geometry/layers/fit_layers.h"
#include "geometry/layers/grid_least_squares.h"
#include "geometry/metrics/grid_point.h"

namespace dgm::bake {

void fit_texture(const LayerInput& in, std::span<const MatchedPoint> points,
                 std::span<const std::array<double, 4>> colours, std::uint32_t rows, std::uint32_t cols,
                 std::span<std::uint8_t> rgba) {
    constexpr double kDamping = 0.05;
    constexpr int kIterations = 15;
    const std::size_t texels = std::size_t{rows} * cols;
    const double down = static_cast<double>(rows - 1) / (in.chart.m - 1),
                 across = static_cast<double>(cols - 1) / (in.chart.n - 1);
    std::vector<GridRow<4>> equations(points.size());
    std::vector<std::array<double, 4>> low(texels), high(texels);
    for (std::size_t t = 0; t < texels; ++t)
        for (std::size_t c = 0; c < 4; ++c) low[t][c] = high[t][c] = rgba[4 * t + c];
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Vec2d at = grid_coordinates(in.chart, points[k]);
        const TexelTaps taps = texel_taps(at.x * down, at.y * across, rows, cols);
        GridRow<4>& row = equations[k];
        row.unknown = taps.texel;
        row.w = taps.weight;
        row.value = colours[k];
        for (std::size_t tap = 0; tap < 4; ++tap)
            for (std::size_t c = 0; c < 4; ++c) {
                row.value[c] -= taps.weight[tap] * rgba[4 * std::size_t{taps.texel[tap]} + c];
                if (taps.weight[tap] <= 0) continue;
                low[taps.texel[tap]][c] = std::min(low[taps.texel[tap]][c], colours[k][c]);
                high[taps.texel[tap]][c] = std::max(high[taps.texel[tap]][c], colours[k][c]);
            }
    }
    const auto step = grid_least_squares<4>(equations, texels, kDamping, kIterations);
    for (std::size_t t = 0; t < texels; ++t)
        for (std::size_t c = 0; c < 4; ++c)
            rgba[4 * t + c] =
                static_cast<std::uint8_t>(std::lround(std::clamp(rgba[4 * t + c] + step[t][c], low[t][c], high[t][c])));
}

}  // namespace dgm::bake
