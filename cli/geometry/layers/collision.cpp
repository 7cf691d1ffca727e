// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/collision.cpp
// Layers `collision` (pyramid of boxes) and `cover` (how far a sample's own quads reach).
#include <dgm/grid.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/layers/layers.h"
#include "model/layer_names.h"

namespace dgm::bake {
namespace {

struct Box {
    Vec3d lo{INFINITY, INFINITY, INFINITY}, hi{-INFINITY, -INFINITY, -INFINITY};
    void add(const Vec3d& p) {
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], p[k]);
            hi[k] = std::max(hi[k], p[k]);
        }
    }
    void add(const Box& b) {
        add(b.lo);
        add(b.hi);
    }
    [[nodiscard]] bool empty() const { return lo.x > hi.x; }
};

float round_down(double x) {
    const auto f = static_cast<float>(x);
    return f > x ? std::nextafterf(f, -INFINITY) : f;
}
float round_up(double x) {
    return -round_down(-x);
}

/// Leaf tile of a strip face: that of its lowest grid sample, else of its first border sample's (u, v).
std::size_t strip_tile(const SampledChart& chart, const Face& face, std::uint32_t tile_rows, std::uint32_t tile_cols) {
    const std::uint32_t lowest = *std::min_element(face.begin(), face.end());
    double i, j;
    if (lowest < chart.grid_count()) {
        i = lowest / chart.n;
        j = lowest % chart.n;
    } else {
        const Vec2d uv = chart.border_uv[lowest - chart.grid_count()];
        i = std::floor(static_cast<float>(uv.x) * static_cast<float>(chart.m - 1));
        j = std::floor(static_cast<float>(uv.y) * static_cast<float>(chart.n - 1));
    }
    const auto tile = [](double x, std::uint32_t count) {
        return static_cast<std::uint32_t>(std::clamp(x / kTileQuads, 0.0, count - 1.0));
    };
    return std::size_t{tile(i, tile_rows)} * tile_cols + tile(j, tile_cols);
}

}  // namespace

model::Layer make_collision(const SampledChart& chart, std::span<const Vec3d> local) {
    std::uint32_t rows = tile_count(chart.m - 1), cols = tile_count(chart.n - 1);
    std::vector<Box> boxes(std::size_t{rows} * cols);
    for (std::uint32_t i = 0; i + 1 < chart.m; ++i)
        for (std::uint32_t j = 0; j + 1 < chart.n; ++j) {
            if (!chart.has_quad(i, j)) continue;
            Box& box = boxes[std::size_t{i / kTileQuads} * cols + j / kTileQuads];
            const std::size_t a = std::size_t{i} * chart.n + j;
            for (std::size_t s : {a, a + 1, a + chart.n, a + chart.n + 1}) box.add(local[s]);
        }
    for (const Face& face : chart.strip)
        for (std::uint32_t s : face) boxes[strip_tile(chart, face, rows, cols)].add(local[s]);
    std::vector<std::uint32_t> levels{rows, cols};
    for (std::size_t first = 0; rows > 1 || cols > 1;) {
        const std::uint32_t up_rows = (rows + 1) / 2, up_cols = (cols + 1) / 2;
        const std::size_t next = boxes.size();
        boxes.resize(next + std::size_t{up_rows} * up_cols);
        for (std::uint32_t r = 0; r < rows; ++r)
            for (std::uint32_t c = 0; c < cols; ++c) {
                const Box child = boxes[first + std::size_t{r} * cols + c];
                if (!child.empty()) boxes[next + std::size_t{r / 2} * up_cols + c / 2].add(child);
            }
        first = next;
        rows = up_rows;
        cols = up_cols;
        levels.push_back(rows);
        levels.push_back(cols);
    }
    model::Layer layer = empty_layer(model::layers::kCollision, model::ElementType::kF32, {boxes.size(), 6});
    layer.attributes["levels"] = levels;
    const auto out = values<float>(layer);
    constexpr float kMax = std::numeric_limits<float>::max();
    for (std::size_t b = 0; b < boxes.size(); ++b)
        for (int k = 0; k < 3; ++k) {
            // A tile without quads has an inverted box: nothing is ever inside, and no number in the file is infinite.
            out[6 * b + k] = boxes[b].empty() ? kMax : round_down(boxes[b].lo[k]);
            out[6 * b + 3 + k] = boxes[b].empty() ? -kMax : round_up(boxes[b].hi[k]);
        }
    return layer;
}

model::Layer make_cover(const SampledChart& chart, std::span<const Vec3d> local) {
    // The farthest point of a triangle from one of its plane's points is a corner; all corners of the quads (and strip
    // faces) round a sample, on every side of its seam.
    std::vector<double> radius(local.size(), 0.0);
    const auto reach = [&](std::size_t s, std::size_t to) {
        double& r = radius[chart.representative[s]];
        r = std::max(r, length(local[s] - local[to]));
    };
    for (std::uint32_t i = 0; i + 1 < chart.m; ++i)
        for (std::uint32_t j = 0; j + 1 < chart.n; ++j) {
            if (!chart.has_quad(i, j)) continue;
            const std::size_t a = std::size_t{i} * chart.n + j;
            const std::size_t quad[4] = {a, a + 1, a + chart.n, a + chart.n + 1};
            for (std::size_t s : quad)
                for (std::size_t to : quad) reach(s, to);
        }
    for (const Face& face : chart.strip)
        for (std::uint32_t s : face)
            for (std::uint32_t to : face) reach(s, to);
    model::Layer layer = empty_layer(model::layers::kCover, model::ElementType::kF32, {chart.m, chart.n});
    const auto out = values<float>(layer);
    for (std::size_t s = 0; s < chart.grid_count(); ++s) out[s] = round_up(radius[chart.representative[s]]);
    return layer;
}

}  // namespace dgm::bake
