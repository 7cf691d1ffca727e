// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/colour.h
// Colour spaces and colour maps of the pictures.
#pragma once
#include <array>
#include <cstdint>

#include "model/tri_mesh.h"

namespace dgm::render {

/// Linear-light RGB, sRGB primaries; 1 is white.
struct Rgb {
    float r = 0, g = 0, b = 0;
    friend constexpr Rgb operator+(Rgb x, Rgb y) { return {x.r + y.r, x.g + y.g, x.b + y.b}; }
    friend constexpr Rgb operator*(Rgb x, Rgb y) { return {x.r * y.r, x.g * y.g, x.b * y.b}; }
    friend constexpr Rgb operator*(Rgb a, float s) { return {a.r * s, a.g * s, a.b * s}; }
    constexpr Rgb& operator+=(Rgb other) { return *this = *this + other; }
};
[[nodiscard]] constexpr Rgb mix(Rgb a, Rgb b, float t) {
    return a * (1 - t) + b * t;
}

/// sRGB transfer function [IEC 61966-2-1]; `to_byte` clamps and rounds to nearest.
[[nodiscard]] float linear_from_byte(std::uint8_t srgb);
[[nodiscard]] std::uint8_t byte_from_linear(float linear);
[[nodiscard]] Rgb linear(model::Rgba8 colour);
[[nodiscard]] model::Rgba8 encoded(Rgb colour);

/// Sequential map, dark violet at 0 to light yellow at 1; NaN is magenta, values outside are clamped.
///
/// Even steps of the argument are even steps of lightness in Oklab [Ottosson 2020], with the hue turning from violet
/// through teal to yellow, so it also reads in grey and with colour-deficient eyes.
[[nodiscard]] model::Rgba8 sequential_colour(double t);

/// Diverging map for -1..1: blue, near-white at 0, red; equal lightness at equal distance from 0. NaN is magenta.
[[nodiscard]] model::Rgba8 diverging_colour(double t);

/// Cyclic map for 0..1: hues of one lightness and chroma.
[[nodiscard]] model::Rgba8 cyclic_colour(double t);

}  // namespace dgm::render
