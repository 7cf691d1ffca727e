// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/colour.cpp
//
// [Ottosson 2020] Bjorn Ottosson. A perceptual color space for image processing. The matrices below are his.
#include "render/colour.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "math/portable.h"

namespace dgm::render {
namespace {
constexpr model::Rgba8 kNotANumber{255, 0, 255, 255};

double cube(double x) {
    return x * x * x;
}

Rgb rgb_from_oklch(double lightness, double chroma, double hue_degrees) {
    const double hue = hue_degrees * std::numbers::pi / 180;
    const double a = chroma * math::cos(hue), b = chroma * math::sin(hue);
    const double l = cube(lightness + 0.3963377774 * a + 0.2158037573 * b);
    const double m = cube(lightness - 0.1055613458 * a - 0.0638541728 * b);
    const double s = cube(lightness - 0.0894841775 * a - 1.2914855480 * b);
    return {static_cast<float>(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
            static_cast<float>(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
            static_cast<float>(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

bool in_gamut(Rgb c) {
    return std::min({c.r, c.g, c.b}) >= 0 && std::max({c.r, c.g, c.b}) <= 1;
}

/// The colour of the asked lightness and hue with the asked chroma, or the largest that sRGB can show.
model::Rgba8 nearest_in_gamut(double lightness, double chroma, double hue_degrees) {
    Rgb colour = rgb_from_oklch(lightness, chroma, hue_degrees);
    if (!in_gamut(colour)) {
        double low = 0, high = chroma;
        for (int step = 0; step < 24; ++step) {
            const double middle = 0.5 * (low + high);
            (in_gamut(rgb_from_oklch(lightness, middle, hue_degrees)) ? low : high) = middle;
        }
        colour = rgb_from_oklch(lightness, low, hue_degrees);
    }
    return encoded(colour);
}

constexpr int kSteps = 256;
using Table = std::array<model::Rgba8, kSteps>;

model::Rgba8 look_up(const Table& table, double t) {
    if (std::isnan(t)) return kNotANumber;
    return table[static_cast<std::size_t>(std::lround(std::clamp(t, 0.0, 1.0) * (kSteps - 1)))];
}

template <class F>
Table tabulate(F colour_of) {
    Table table;
    for (int i = 0; i < kSteps; ++i) table[static_cast<std::size_t>(i)] = colour_of(i / double{kSteps - 1});
    return table;
}
}  // namespace

float linear_from_byte(std::uint8_t srgb) {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> t{};
        for (int i = 0; i < 256; ++i) {
            const double c = i / 255.0;
            t[static_cast<std::size_t>(i)] =
                static_cast<float>(c <= 0.04045 ? c / 12.92 : math::pow((c + 0.055) / 1.055, 2.4));
        }
        return t;
    }();
    return table[srgb];
}

std::uint8_t byte_from_linear(float linear) {
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 255;
    const double c = linear;
    const double s = c <= 0.0031308 ? 12.92 * c : 1.055 * math::pow(c, 1 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(std::lround(255 * s));
}

Rgb linear(model::Rgba8 c) {
    return {linear_from_byte(c.r), linear_from_byte(c.g), linear_from_byte(c.b)};
}

model::Rgba8 encoded(Rgb c) {
    return {byte_from_linear(c.r), byte_from_linear(c.g), byte_from_linear(c.b), 255};
}

model::Rgba8 sequential_colour(double t) {
    static const Table table =
        tabulate([](double x) { return nearest_in_gamut(0.27 + 0.65 * x, 0.13 + 0.05 * x, 300 - 195 * x); });
    return look_up(table, t);
}

model::Rgba8 diverging_colour(double t) {
    static const Table table = tabulate([](double x) {
        const double side = 2 * x - 1;
        return nearest_in_gamut(0.97 - 0.5 * std::abs(side), 0.19 * std::abs(side), side < 0 ? 255 : 28);
    });
    return look_up(table, 0.5 + 0.5 * t);
}

model::Rgba8 cyclic_colour(double t) {
    static const Table table = tabulate([](double x) { return nearest_in_gamut(0.66, 0.16, 360 * x); });
    return look_up(table, t - std::floor(t));
}

}  // namespace dgm::render
