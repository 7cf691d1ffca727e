// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/sampling.h
// Deterministic sample points: the same picture on every run and with any number of threads.
//
// [Roberts 2018] Martin Roberts. The unreasonable effectiveness of quasirandom sequences: the additive recurrence R2.
#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>

#include "math/portable.h"
#include "model/vec.h"

namespace dgm::render {

/// Van der Corput sequence in base 2, in [0, 1).
[[nodiscard]] inline double radical_inverse(std::uint32_t i) {
    i = (i << 16) | (i >> 16);
    i = ((i & 0x00ff00ffu) << 8) | ((i & 0xff00ff00u) >> 8);
    i = ((i & 0x0f0f0f0fu) << 4) | ((i & 0xf0f0f0f0u) >> 4);
    i = ((i & 0x33333333u) << 2) | ((i & 0xccccccccu) >> 2);
    i = ((i & 0x55555555u) << 1) | ((i & 0xaaaaaaaau) >> 1);
    return i * 0x1p-32;
}

/// Two numbers in [0, 1) that differ from pixel to pixel without pattern.
[[nodiscard]] inline model::Vec2d pixel_shift(std::uint32_t x, std::uint32_t y, std::uint32_t purpose) {
    std::uint64_t h = (static_cast<std::uint64_t>(x) << 34) ^ (static_cast<std::uint64_t>(y) << 8) ^ purpose;
    h ^= h >> 31;
    h *= 0x7fb5d329728ea185u;
    h ^= h >> 27;
    h *= 0x81dadef4bc2dd44du;
    h ^= h >> 33;
    return {static_cast<double>(h >> 32) * 0x1p-32, static_cast<double>(h & 0xffffffffu) * 0x1p-32};
}

/// Point `i` of the R2 sequence, moved by `shift` on the torus.
[[nodiscard]] inline model::Vec2d r2_point(std::uint32_t i, model::Vec2d shift) {
    const double x = shift.x + 0.7548776662466927 * i, y = shift.y + 0.5698402909980532 * i;
    return {x - std::floor(x), y - std::floor(y)};
}

/// Unit vectors a, b that make a right-handed frame with the unit vector n.
inline void tangent_frame(const model::Vec3d& n, model::Vec3d& a, model::Vec3d& b) {
    a = normalized(std::abs(n.x) < 0.6 ? cross(n, {1, 0, 0}) : cross(n, {0, 1, 0}));
    b = cross(n, a);
}

/// Direction about n with density cos / pi.
[[nodiscard]] inline model::Vec3d cosine_direction(const model::Vec3d& n, model::Vec2d sample) {
    model::Vec3d a, b;
    tangent_frame(n, a, b);
    const double r = std::sqrt(sample.x), phi = 2 * std::numbers::pi * sample.y;
    const auto [sine, cosine] = math::sine_cosine(phi);
    return r * cosine * a + r * sine * b + std::sqrt(1 - sample.x) * n;
}

/// Direction within the cone about `axis` whose half angle has the given sine, uniform over its disc.
[[nodiscard]] inline model::Vec3d cone_direction(const model::Vec3d& axis, double half_angle_sine,
                                                 model::Vec2d sample) {
    model::Vec3d a, b;
    tangent_frame(axis, a, b);
    const double r = half_angle_sine * std::sqrt(sample.x), phi = 2 * std::numbers::pi * sample.y;
    const auto [sine, cosine] = math::sine_cosine(phi);
    return normalized(r * cosine * a + r * sine * b + std::sqrt(1 - r * r) * axis);
}

}  // namespace dgm::render
