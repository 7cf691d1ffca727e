// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/bake_sweep.h
// dgm-bench bake: cost and benefit of each choice of dgm-bake on the user's meshes.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/progress_bar.h"
#include "bench/repeat.h"
#include "bench/table.h"

namespace dgm::bench {

struct BakeSweepOptions {
    std::vector<std::filesystem::path> assets;
    std::vector<std::string> methods, precisions, fits, layers;  ///< layers: names joined by '+', or "all"
    std::vector<std::uint32_t> sizes;                            ///< samples a side, ascending
    std::vector<std::uint32_t> compared;  ///< where one thing at a time is changed; empty: second and third size
    /// All combinations; else the default (auto, f32, l2, all) at every size, and one thing changed at a time at some.
    bool full = false;
    BakeRepeats repeats;
};

/// One point of the sweep.
struct BakePoint {
    std::string method;
    std::uint32_t side = 0;
    std::string precision, fit, layers;
    friend bool operator==(const BakePoint&, const BakePoint&) = default;
};

/// The defaults of dgm-bake, with which every other point is compared.
[[nodiscard]] BakePoint default_point();

/// The grid of the paper, sampled and not fitted.
[[nodiscard]] BakePoint paper_point();

/// The points that are baked for one asset, the paper's among them; no point twice.
[[nodiscard]] std::vector<BakePoint> plan_points(const BakeSweepOptions& options);

/// How often it is baked if the user asks for `asked` times: large grids take most of a sweep's time and spread least.
/// Above 300 a side at most three times, above 600 once.
[[nodiscard]] unsigned repetitions_of(const BakePoint& point, unsigned asked);

/// Expected time, in any unit: a progress bar counts it.
[[nodiscard]] double work_of(const BakePoint& point, unsigned repetitions);

/// Bakes all points of all assets. A point that is refused is a row that says why.
/// @throws model::Error kUsage for a word that dgm-bake does not know, kInterrupted
[[nodiscard]] Run sweep_bakes(const BakeSweepOptions& options, bool quiet);

}  // namespace dgm::bench
