// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/resample_plane.cpp
#include "export/resample_plane.h"

#include <algorithm>
#include <cmath>

namespace dgm::exporter {
namespace {

/// Which pixels of a line a pixel of the new line reads, and how much.
struct Tap {
    std::uint32_t first = 0;
    std::vector<double> weights;
};

std::vector<Tap> taps_of(std::uint32_t from, std::uint32_t to) {
    const double step = to > 1 ? static_cast<double>(from - 1) / (to - 1) : 0;
    const double reach = std::max(1.0, step);
    std::vector<Tap> out(to);
    for (std::uint32_t k = 0; k < to; ++k) {
        const double at = k * step;
        const double last = std::min<double>(from - 1, std::floor(at + reach));
        out[k].first = static_cast<std::uint32_t>(std::max(0.0, std::ceil(at - reach)));
        for (std::uint32_t p = out[k].first; p <= static_cast<std::uint32_t>(last); ++p)
            out[k].weights.push_back(std::max(0.0, 1 - std::abs(p - at) / reach));
    }
    return out;
}

/// Sums along the rows; the result is turned, so that the same function sums along the columns.
Plane sum_and_turn(const Plane& plane, const std::vector<Tap>& taps) {
    Plane out{plane.height, static_cast<std::uint32_t>(taps.size()), plane.channels, {}};
    out.values.assign(out.pixels() * out.channels, 0.0);
    for (std::uint32_t y = 0; y < plane.height; ++y)
        for (std::size_t x = 0; x < taps.size(); ++x)
            for (std::size_t t = 0; t < taps[x].weights.size(); ++t) {
                const std::size_t source = std::size_t{y} * plane.width + taps[x].first + t;
                const std::size_t target = x * out.width + y;
                for (std::uint32_t c = 0; c < plane.channels; ++c)
                    out.values[target * plane.channels + c] +=
                        taps[x].weights[t] * plane.values[source * plane.channels + c];
            }
    return out;
}

}  // namespace

Plane resampled(const Plane& plane, const Plane& weights, std::uint32_t width, std::uint32_t height) {
    if (plane.width == width && plane.height == height) return plane;
    // One more channel sums the weights.
    Plane weighted{plane.width, plane.height, plane.channels + 1, {}};
    weighted.values.reserve(plane.pixels() * weighted.channels);
    for (std::size_t k = 0; k < plane.pixels(); ++k) {
        const double weight = weights.values.empty() ? 1 : weights.values[k];
        for (std::uint32_t c = 0; c < plane.channels; ++c)
            weighted.values.push_back(weight > 0 ? weight * plane.values[k * plane.channels + c] : 0);
        weighted.values.push_back(weight);
    }
    const Plane sums = sum_and_turn(sum_and_turn(weighted, taps_of(plane.width, width)), taps_of(plane.height, height));
    Plane out{width, height, plane.channels, {}};
    out.values.reserve(out.pixels() * out.channels);
    for (std::size_t k = 0; k < out.pixels(); ++k) {
        const double weight = sums.values[(k + 1) * sums.channels - 1];
        for (std::uint32_t c = 0; c < out.channels; ++c)
            out.values.push_back(weight > 0 ? sums.values[k * sums.channels + c] / weight : 0);
    }
    return out;
}

}  // namespace dgm::exporter
