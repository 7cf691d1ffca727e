// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/cloth_sweep.h
// dgm-bench cloth: time of a frame of dgm::cloth against its distance from the closed form, and with contact.
#pragma once
#include <cstdint>
#include <vector>

#include "bench/table.h"

namespace dgm::bench {

struct ClothSweepOptions {
    std::vector<std::uint32_t> sizes{33, 65, 129, 257};
    std::vector<std::uint32_t> substeps{1, 2};
    std::vector<std::uint32_t> cycles{1, 2};
    std::vector<std::uint32_t> levels{0};  ///< strides that are used; 0: all
    double modulus = 2e4;                  ///< N/m, of warp and weft
    std::size_t frames = 120;              ///< of each setting, all timed
    double time_limit_seconds = 600;       ///< of a bake
};

/// A sheet of 1 m and 0.2 kg is hung by its first row, then it falls on things.
///
/// @throws model::Error kInterrupted; exceptions of bakes and reads
[[nodiscard]] Run sweep_cloth(const ClothSweepOptions& options, bool quiet);

}  // namespace dgm::bench
