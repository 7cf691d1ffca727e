// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/texture_padding.cpp
#include "edit/texture_padding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "geometry/layers/dilate.h"
#include "model/element.h"
#include "model/layer_names.h"

namespace dgm::edit {
namespace {

using model::element;
using model::Layer;

struct Point {
    double x = 0, y = 0;  ///< row and column, in texels
};

/// Marks the texels whose middle is in the triangle, or on its edge.
void cover(std::span<const Point, 3> corner, std::uint32_t rows, std::uint32_t cols, std::vector<char>& covered) {
    const auto [low_x, high_x] = std::minmax({corner[0].x, corner[1].x, corner[2].x});
    const auto [low_y, high_y] = std::minmax({corner[0].y, corner[1].y, corner[2].y});
    const auto side = [](const Point& a, const Point& b, double x, double y) {
        return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
    };
    constexpr double kSlack = 1e-9;
    for (double i = std::max(0.0, std::ceil(low_x - kSlack)); i <= std::min(high_x + kSlack, rows - 1.0); ++i)
        for (double j = std::max(0.0, std::ceil(low_y - kSlack)); j <= std::min(high_y + kSlack, cols - 1.0); ++j) {
            const double a = side(corner[0], corner[1], i, j), b = side(corner[1], corner[2], i, j),
                         c = side(corner[2], corner[0], i, j);
            if (std::min({a, b, c}) >= -kSlack || std::max({a, b, c}) <= kSlack)
                covered[static_cast<std::size_t>(i) * cols + static_cast<std::size_t>(j)] = 1;
        }
}

/// Which texels lie on the surface: on its quads, or on the strip along its border.
std::vector<char> covered_texels(const model::Chart& chart, std::uint32_t rows, std::uint32_t cols) {
    std::vector<char> out(std::size_t{rows} * cols, 0);
    const Layer *mask = chart.find(model::layers::kMask), *strip = chart.find(model::layers::kBorderFaces),
                *border_uv = chart.find(model::layers::kBorderUv);
    const std::uint32_t m = chart.rows, n = chart.cols;
    const double down = static_cast<double>(rows - 1) / (m - 1), across = static_cast<double>(cols - 1) / (n - 1);
    const auto on_surface = [&](std::uint32_t s) { return mask == nullptr || element<std::uint8_t>(*mask, s) != 0; };
    const auto grid = [&](std::uint32_t s) { return Point{s / n * down, s % n * across}; };
    for (std::uint32_t i = 0; i + 1 < m; ++i)
        for (std::uint32_t j = 0; j + 1 < n; ++j) {
            const std::uint32_t a = i * n + j, b = a + n, c = b + 1, d = a + 1;
            if (!(on_surface(a) && on_surface(b) && on_surface(c) && on_surface(d))) continue;
            cover(std::array{grid(a), grid(b), grid(c)}, rows, cols, out);
            cover(std::array{grid(a), grid(c), grid(d)}, rows, cols, out);
        }
    if (strip == nullptr || border_uv == nullptr) return out;
    const auto place = [&](std::uint32_t s) {
        if (s < m * n) return grid(s);
        const std::size_t b = s - std::size_t{m} * n;
        return Point{static_cast<double>(element<float>(*border_uv, 2 * b)) * (rows - 1),
                     static_cast<double>(element<float>(*border_uv, 2 * b + 1)) * (cols - 1)};
    };
    for (std::size_t f = 0; f < strip->shape[0]; ++f)
        cover(std::array{place(element<std::uint32_t>(*strip, 3 * f)), place(element<std::uint32_t>(*strip, 3 * f + 1)),
                         place(element<std::uint32_t>(*strip, 3 * f + 2))},
              rows, cols, out);
    return out;
}

}  // namespace

std::uint64_t pad_texture(const model::Chart& chart, std::span<const char> changed, Layer& texture) {
    const auto rows = static_cast<std::uint32_t>(texture.shape[0]), cols = static_cast<std::uint32_t>(texture.shape[1]);
    if (rows < 2 || cols < 2 || chart.rows < 2 || chart.cols < 2) return 0;
    const std::vector<std::uint32_t> from = bake::nearest_covered(covered_texels(chart, rows, cols), rows, cols);
    constexpr std::size_t kTexelBytes = 4;
    std::uint64_t out = 0;
    for (std::size_t t = 0; t < from.size(); ++t) {
        if (changed[t] != 0 || from[t] == t || from[t] == bake::kNone || changed[from[t]] == 0) continue;
        std::byte* to = texture.bytes.data() + kTexelBytes * t;
        const std::byte* colour = texture.bytes.data() + kTexelBytes * from[t];
        if (std::memcmp(to, colour, kTexelBytes) == 0) continue;
        std::memcpy(to, colour, kTexelBytes);
        ++out;
    }
    return out;
}

}  // namespace dgm::edit
