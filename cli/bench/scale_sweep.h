// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/scale_sweep.h
// dgm-bench scale: time and memory as meshes and batches grow, with one thread and with more.
#pragma once
#include <cstdint>
#include <vector>

#include "bench/table.h"

namespace dgm::bench {

struct ScaleOptions {
    std::vector<std::uint64_t> faces{10'000, 30'000, 100'000, 300'000, 1'000'000, 2'000'000};
    std::vector<unsigned> assets{1, 4, 16, 64};
    std::vector<unsigned> threads{1, 2};
    std::uint64_t faces_of_assets = 10'000;
    std::uint32_t side = 257;
    std::uint64_t repeated_faces = 100'000;  ///< meshes up to this size are baked three times
    double time_limit_seconds = 3600;
};

/// @throws model::Error kInterrupted
[[nodiscard]] Run sweep_scale(const ScaleOptions& options, bool quiet);

}  // namespace dgm::bench
