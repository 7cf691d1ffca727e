// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/tick_time.h
// Measures the time that touches of a baked asset take in a haptic loop.
#pragma once
#include <dgm/asset.h>

#include <cstdint>
#include <filesystem>
#include <vector>

#include "scene/scene_file.h"
#include "scene/scene_plan.h"

namespace dgm::scene {

struct TickTime {
    double median = 0, p99 = 0;  ///< seconds, compute time of dgm::tick()
    std::uint32_t ticks = 0;     ///< how many were measured
    std::uint32_t samples = 0;   ///< in reach of the tool, most of all ticks
    std::uint32_t reach = 0;     ///< b, grid steps
    std::uint64_t state_bytes = 0;
};

/// A file that the runtime has mapped. @throws model::Error kInternal if it refuses it
[[nodiscard]] Asset open_baked(const std::filesystem::path& dgm);

/// Its charts and layers: nothing but the index is read.
[[nodiscard]] std::vector<BakedChart> charts_of(const Asset& asset);

/// Lets a tool press into the largest chart along a random walk over the samples, 2,000 ticks, the first 200 not
/// counted. A figure of this machine at this moment, not a verdict.
/// @throws model::Error kInternal if the runtime refuses the chart
[[nodiscard]] TickTime measure_tick(const Asset& asset, Footprint footprint, Reach reach);

}  // namespace dgm::scene
