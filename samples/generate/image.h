// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/image.h
// Pictures in linear rows, top row first, and their way into a PNG.
#pragma once
#include <cstddef>
#include <filesystem>
#include <vector>

#include "model/vec.h"

namespace dgm::samples {

/// sRGB-encoded colour, each channel 0..1.
using Colour = model::Vec3d;

inline Colour mix(const Colour& a, const Colour& b, double t) {
    return a + (b - a) * t;
}
/// From the usual 0..255 figures.
constexpr Colour rgb(int r, int g, int b) {
    return {r / 255.0, g / 255.0, b / 255.0};
}

/// A colour and a height (0..1, 0.5 neutral) for every pixel.
struct Picture {
    int width = 0, height = 0;
    std::vector<Colour> colour;  ///< width * height, row 0 at the top
    std::vector<double> relief;  ///< same shape

    Picture(int w, int h)
        : width(w), height(h), colour(static_cast<std::size_t>(w) * h), relief(static_cast<std::size_t>(w) * h, 0.5) {}
    [[nodiscard]] std::size_t at(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
};

/// Writes `picture.colour` as 8-bit RGB. Throws model::Error (kWriteFailed).
void write_colour_png(const Picture& picture, const std::filesystem::path& path);

/// Writes `picture.relief` as 8-bit gray. Throws model::Error (kWriteFailed).
void write_relief_png(const Picture& picture, const std::filesystem::path& path);

}  // namespace dgm::samples
