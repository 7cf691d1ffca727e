// SPDX-License-Identifier: MIT
// libdgm/src/contact/contact_polish.cpp
// The volume that rounding to float leaves: a few samples take it, one after another, since it is linear in each.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "contact/contact_resolver.h"

namespace dgm::detail {

Double3 Resolver::volume_gradient(std::uint32_t k) const noexcept {
    const std::uint32_t cols = s_.tables.cols;
    Double3 g;  // a sixth of the ring's area vectors
    for (const std::uint32_t a : {k, k - 1, k - cols, k - cols - 1}) {
        const std::uint32_t qi = a / cols, qj = a % cols;
        for (const auto& f : quad_triangles(qi, qj, cols, s_.tables.diagonal(qi, qj)))
            if (f[0] == k || f[1] == k || f[2] == k)
                g = g +
                    cross(widen(s_.point(f[1])) - widen(s_.point(f[0])), widen(s_.point(f[2])) - widen(s_.point(f[0])));
    }
    return (1.0 / 6) * g;
}

// Removes the error of rounding to float: moves single coordinates by a few units in the last place. In small contacts
// one such unit along the normal is more than a millionth of the removed volume. Along the surface it is less, and the
// difference of two may be arbitrarily small.
double Resolver::nudge(std::span<const std::uint32_t> samples, double left) noexcept {
    constexpr double kUnits = 16;
    struct Coordinate {
        float* at = nullptr;
        std::uint32_t sample = 0, axis = 0;
        double gain = 0;  ///< of volume by one unit
    };
    const auto coordinate = [&](std::uint32_t sample, std::uint32_t axis, const Double3& g) {
        float* const at = (axis == 0 ? s_.now.x : axis == 1 ? s_.now.y : s_.now.z) + sample;
        const float size = std::fabs(*at);
        const double unit = double{std::nextafter(size, std::numeric_limits<float>::infinity())} - double{size};
        return Coordinate{at, sample, axis, unit * (axis == 0 ? g.x : axis == 1 ? g.y : g.z)};
    };
    const auto move = [&](const Coordinate& c, double units) {
        const double size = std::fabs(double{*c.at}), old = *c.at;
        const double unit =
            double{std::nextafter(static_cast<float>(size), std::numeric_limits<float>::infinity())} - size;
        *c.at = static_cast<float>(old + units * unit);
        left += c.gain / unit * (double{*c.at} - old);
    };
    const auto needed = [](const Coordinate& c, double rest) {
        const double units = std::nearbyint(-rest / c.gain);
        return std::fabs(units) <= kUnits ? units : 0;  // not for NaN
    };
    Coordinate finest;
    for (const std::uint32_t k : samples) {
        const Double3 g = volume_gradient(k);
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            const Coordinate c = coordinate(k, axis, g);
            if (c.gain == 0) continue;
            move(c, needed(c, left));
            if (finest.at == nullptr || std::fabs(c.gain) < std::fabs(finest.gain)) finest = c;
        }
    }
    if (std::fabs(6 * left) <= kAimed * std::fabs(removed_) || finest.at == nullptr) return left;
    Coordinate best;
    double best_units = 0, least = std::fabs(left);
    for (const std::uint32_t k : samples) {
        const Double3 g = volume_gradient(k);
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            const Coordinate c = coordinate(k, axis, g);
            for (double units = -kUnits; units <= kUnits && c.at != finest.at; ++units) {
                const double rest = left + units * c.gain, then = rest + needed(finest, rest) * finest.gain;
                if (!(std::fabs(then) < least)) continue;
                best = c;
                best_units = units;
                least = std::fabs(then);
            }
        }
    }
    if (best.at == nullptr) return left;
    move(best, best_units);
    finest = coordinate(finest.sample, finest.axis, volume_gradient(finest.sample));  // the other may be beside it
    move(finest, needed(finest, left));
    return left;
}

void Resolver::polish(double error) noexcept {
    if (std::fabs(error) > 1e-3 * std::fabs(removed_)) return;
    constexpr std::uint32_t kSamples = 32;
    std::uint32_t chosen[kSamples], count = 0;
    const std::uint32_t cols = s_.tables.cols;
    const auto free = [&](std::uint32_t k) { return c_.weight[k] > 0.25f && (s_.ring[k] & kRingIrregular) == 0; };
    const auto choose = [&](std::uint32_t k) {
        if (probe(shape_, widen(s_.point(k))).distance > 1e-3 * double{s_.mean_step}) chosen[count++] = k;
    };
    for (std::uint32_t e = 0; e < c_.tile_count && count < kSamples; ++e) {
        if ((c_.tile_bits[c_.tiles[e]] & kTilePsi) == 0) continue;
        const Rect r = c_.rects[c_.tiles[e]];
        const std::uint32_t k = (r.i0 + r.i1) / 2 * cols + (r.j0 + r.j1) / 2;
        if (free(k)) choose(k);
    }
    // A ring of few tiles: any.
    if (count < kSamples / 4) {
        count = 0;
        for (std::uint32_t e = 0; e < c_.tile_count; ++e)
            if ((c_.tile_bits[c_.tiles[e]] & kTilePsi) != 0)
                each_sample(c_.tiles[e], [&](std::uint32_t k) {
                    if (count < kSamples && free(k)) choose(k);
                });
    }
    double left = error / 6;
    for (std::uint32_t e = 0; e < count; ++e) {
        const std::uint32_t k = chosen[e];
        const Double3 o = widen(s_.point(k)), g = volume_gradient(k), n = widen(StateImpl::at(s_.normal, k));
        const double rate = dot(g, n);
        if (!(rate != 0)) continue;
        const double step = -left / (count - e) / rate;
        if (!(std::fabs(step) < 0.01 * double{s_.mean_step})) continue;
        put(k, o + step * n);
        left += dot(g, widen(s_.point(k)) - o);
    }
    if (std::fabs(6 * left) > kAimed * std::fabs(removed_)) left = nudge({chosen, count}, left);
    report_.volume_error = 6 * left / removed_;
}

}  // namespace dgm::detail
