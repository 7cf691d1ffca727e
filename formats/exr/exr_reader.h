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

/// Content of the headers, without any pixel.
struct ExrHead {
    model::MapSet maps;      ///< no charts
    bool multipart = false;  ///< written with ExrLayout::kMultipart: no part holds several layers
};

/// Reads the headers alone, and looks whether all rows are there; the pixels themselves are not looked at. Thread-safe.
/// @throws model::Error as read_exr, also for a file that lost its end
[[nodiscard]] ExrHead read_exr_head(const std::filesystem::path& path, const ExrReadLimits& limits = {});

}  // namespace dgm::formats
