// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/file_times.h
// Measures the cost of loading a .dgm.
#pragma once
#include <cstdint>
#include <filesystem>

#include "bench/statistics.h"

namespace dgm::bench {

struct FileTimes {
    Figure load_seconds;         ///< open, check and read every layer (its hash), pages in memory
    Figure reconstruct_seconds;  ///< positions, normals and triangles of all charts into memory that is there
    std::uint64_t bytes = 0, geometry_bytes = 0;  ///< of the file; of geometry, diagonals, seams, mask and border
    std::uint64_t triangles = 0;
};

/// One thread, warm file cache. @throws model::Error kReadFailed with what the runtime says
[[nodiscard]] FileTimes measure_file(const std::filesystem::path& dgm);

}  // namespace dgm::bench
