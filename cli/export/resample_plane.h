// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/resample_plane.h
// Pictures of numbers in another size.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace dgm::exporter {

/// Row-major, row 0 at the top, channels interleaved.
struct Plane {
    std::uint32_t width = 0, height = 0, channels = 1;
    std::vector<double> values;
    [[nodiscard]] std::size_t pixels() const { return std::size_t{width} * height; }
};

/// A tent filter whose corner pixels stay on the corner pixels: pixel k of n reads around k (m - 1) / (n - 1) of m,
/// with a reach of one pixel of the coarser of the two pictures.
/// @param weights  one channel, the plane's size: how much a pixel counts; empty: all alike. Where none counts, the
///                 result is 0
[[nodiscard]] Plane resampled(const Plane& plane, const Plane& weights, std::uint32_t width, std::uint32_t height);

}  // namespace dgm::exporter
