// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/stability_sweep.h
// dgm-bench stability: error and time as inputs get harder; where methods start to fail, and what takes over.
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
    double time_limit_seconds = 60;  ///< of one bake: what takes longer has failed
};

/// @throws model::Error kUsage for an unknown word, kInterrupted
[[nodiscard]] Run sweep_stability(const StabilityOptions& options, bool quiet);

/// "sliver: tutte refuses from 1e-12 on (DGM3003 MAP_INVALID)", and for auto which methods it chose. `table` is that of
/// sweep_stability.
[[nodiscard]] std::vector<std::string> failure_lines(const Table& table);

/// The names of the families of meshes.
[[nodiscard]] std::vector<std::string> family_names();

}  // namespace dgm::bench
