// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_reader.h
// OpenEXR to MapSet: the way back of exr_writer.h.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "model/map_set.h"

namespace dgm::formats {

struct ExrReadLimits {
    std::uint64_t max_pixels_per_part = std::uint64_t{1} << 28;
    std::uint64_t max_total_bytes = std::uint64_t{16} << 30;  ///< of all layers, decoded
    int max_parts = 1 << 20;
};

/// Reads a file that write_exr wrote, and the files beside it that hold layers of other sizes. Other programs may have
/// saved them again: other compression, whole numbers and halves as floats, parts without names, attributes in another
/// order. Thread-safe.
/// @throws model::Error kFileMissing (place is the file that is not there), kReadFailed, kExrUnreadable (not an EXR,
///         not a map of ours, of an earlier layout, damaged, or too large), kMissingChannel (what another program
///         dropped), kHashMismatch (place is the layer's path, or "/"), kBadVersion
[[nodiscard]] model::MapSet read_exr(const std::filesystem::path& path, const ExrReadLimits& limits = {});

/// Content of the headers, without any pixel.
struct ExrHead {
    model::MapSet maps;               ///< charts with layers that have no bytes
    bool multipart = false;           ///< written with ExrLayout::kMultipart
    std::vector<std::string> beside;  ///< names of the other files that hold layers of it, for exr_side_path
};

/// Reads the headers alone, and looks whether all rows of all files are there; the pixels themselves are not looked at.
/// Thread-safe.
/// @throws model::Error as read_exr, also for a file that lost its end
[[nodiscard]] ExrHead read_exr_head(const std::filesystem::path& path, const ExrReadLimits& limits = {});

enum class ExrPixels : std::uint8_t { kRead, kSkip };

/// read_exr() or read_exr_head(), by `pixels`, in this process whatever set_exr_reader() says; with pixels only the
/// maps are filled in. @throws model::Error as they
[[nodiscard]] ExrHead read_exr_here(const std::filesystem::path& path, const ExrReadLimits& limits, ExrPixels pixels);

/// From now on read_exr() and read_exr_head() call `reader`, which does what read_exr_here() does elsewhere; an empty
/// one ends that. Not thread-safe.
using ExrReader = std::function<ExrHead(const std::filesystem::path&, const ExrReadLimits&, ExrPixels)>;
void set_exr_reader(ExrReader reader);

}  // namespace dgm::formats
