// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/image_lookup.h
// Bilinear look-up with repeat, texture coordinates with v up (OBJ), texel centres at half-integers.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "image/image.h"
#include "model/vec.h"

namespace dgm::bake {

struct BilinearTaps {
    std::uint32_t x[2], y[2];
    double fx, fy;
};

/// The four texels around uv and their weights; coordinates that are not finite read the first texel.
[[nodiscard]] inline BilinearTaps bilinear_taps(model::Vec2d uv, std::uint32_t width, std::uint32_t height) {
    const auto axis = [](double t, std::uint32_t size, std::uint32_t out[2]) {
        if (!std::isfinite(t)) t = 0;
        const double x = (t - std::floor(t)) * size - 0.5, lo = std::floor(x);
        const auto wrap = [&](double k) { return static_cast<std::uint32_t>(std::fmod(k + size, size)); };
        out[0] = std::min(wrap(lo), size - 1);
        out[1] = std::min(wrap(lo + 1), size - 1);
        return x - lo;
    };
    BilinearTaps taps{};
    taps.fx = axis(uv.x, width, taps.x);
    taps.fy = axis(1 - uv.y, height, taps.y);
    return taps;
}

[[nodiscard]] inline model::Rgba8 lookup(const formats::Image& image, model::Vec2d uv) {
    const BilinearTaps t = bilinear_taps(uv, image.width, image.height);
    const auto mix = [&](auto channel) {
        const double top = channel(image.at(t.x[0], t.y[0])) * (1 - t.fx) + channel(image.at(t.x[1], t.y[0])) * t.fx;
        const double bottom = channel(image.at(t.x[0], t.y[1])) * (1 - t.fx) + channel(image.at(t.x[1], t.y[1])) * t.fx;
        return static_cast<std::uint8_t>(std::lround(top * (1 - t.fy) + bottom * t.fy));
    };
    return {mix([](model::Rgba8 c) { return c.r; }), mix([](model::Rgba8 c) { return c.g; }),
            mix([](model::Rgba8 c) { return c.b; }), mix([](model::Rgba8 c) { return c.a; })};
}

[[nodiscard]] inline double lookup(const formats::FloatImage& image, model::Vec2d uv) {
    const BilinearTaps t = bilinear_taps(uv, image.width, image.height);
    return (image.at(t.x[0], t.y[0]) * (1 - t.fx) + image.at(t.x[1], t.y[0]) * t.fx) * (1 - t.fy) +
           (image.at(t.x[0], t.y[1]) * (1 - t.fx) + image.at(t.x[1], t.y[1]) * t.fx) * t.fy;
}

}  // namespace dgm::bake
