// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/closest_samples.h
// Finds the source's closest points under a fitted chart, point by point.
#pragma once
#include <cstdint>

#include "geometry/chart/sampled_chart.h"

namespace dgm::bake {

/// For each point of a rows x cols grid over the square, the closest point of the source (as a face of chart.disk) to
/// the chart's surface there. An unfitted chart has its rasterization instead. face is kNone off the surface.
[[nodiscard]] SampleGrid closest_samples(const SampledChart& chart, std::uint32_t rows, std::uint32_t cols);

}  // namespace dgm::bake
