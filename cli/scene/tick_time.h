// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/tick_time.h
// What touching a baked asset costs a haptic loop.
#pragma once
#include <cstdint>
#include <filesystem>

#include "scene/scene_file.h"

namespace dgm::scene {

struct TickTime {
    double median = 0, p99 = 0;  ///< seconds, compute time of dgm::tick()
    std::uint32_t ticks = 0;     ///< how many were measured
    std::uint32_t samples = 0;   ///< in reach of the tool, most of all ticks
    std::uint32_t reach = 0;     ///< b, grid steps
    std::uint64_t state_bytes = 0;
};

/// Opens the file and lets a tool press into its largest chart along a random walk over the samples, 2,000 ticks, the
/// first 200 not counted. A figure of this machine at this moment, not a verdict.
/// @throws model::Error kInternal if the runtime refuses the file
[[nodiscard]] TickTime measure_tick(const std::filesystem::path& dgm, Footprint footprint, Reach reach);

}  // namespace dgm::scene
