// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_reader.h
// OpenEXR to MapSet: the way back of exr_writer.h.
#pragma once
#include <cstdint>
#include <filesystem>

#include "model/map_set.h"

namespace dgm::formats {

struct ExrReadLimits {
    std::uint64_t max_pixels_per_part = std::uint64_t{1} << 28;
    std::uint64_t max_total_bytes = std::uint64_t{16} << 30;  ///< of all layers, decoded
    int max_parts = 1 << 20;
};

/// Reads a file that write_exr wrote. Thread-safe.
/// @throws model::Error kFileMissing, kReadFailed, kExrUnreadable (not an EXR, not one of ours, damaged, or too large),
/// kMissingChannel, kHashMismatch (place is the layer's path, or "/"), kBadVersion
[[nodiscard]] model::MapSet read_exr(const std::filesystem::path& path, const ExrReadLimits& limits = {});

}  // namespace dgm::formats
