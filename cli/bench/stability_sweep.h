// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/stability_sweep.h
// dgm-bench stability: error and time as inputs get harder; where methods start to fail, and which takes over.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bench/table.h"

namespace dgm::bench {

struct StabilityOptions {
    std::vector<std::string> methods, families;  ///< families: empty for all
    std::uint32_t side = 33;
    unsigned jobs = 1;
    double time_limit_seconds = 60;  ///< of one bake: a longer one has failed
};

/// @throws model::Error kUsage for an unknown word, kInterrupted
[[nodiscard]] Run sweep_stability(const StabilityOptions& options, bool quiet);

/// Where each method starts to fail, and which one auto takes instead:
/// "genus: mvc and tutte fail at 16 (DGM3006 GRID_TOO_SMALL), 5 of 6 levels baked; arap bakes every level; auto takes
/// stretch, from 16 on arap". A method that ran out of time is said to have done so: on a busy machine that is no
/// failure of its own. `table` is that of sweep_stability.
[[nodiscard]] std::vector<std::string> failure_lines(const Table& table);

/// The names of the families of meshes.
[[nodiscard]] std::vector<std::string> family_names();

}  // namespace dgm::bench
