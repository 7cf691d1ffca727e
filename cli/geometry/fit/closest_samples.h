// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/closest_samples.h
// What of the source lies under a fitted chart, point by point.
#pragma once
#include <cstdint>

#include "geometry/chart/sampled_chart.h"

namespace dgm::bake {

/// For each point of a rows x cols grid over the square, the closest point of the source (as a face of chart.disk) to
/// the chart's surface there: what a rasterization is for an unfitted chart. face is kNone off the surface.
[[nodiscard]] SampleGrid closest_samples(const SampledChart& chart, std::uint32_t rows, std::uint32_t cols);

}  // namespace dgm::bake
