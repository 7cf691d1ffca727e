// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_headers.h
// A look at the headers of an EXR before OpenEXR is let at them.
#pragma once
#include <cstdint>
#include <filesystem>

#include "exr/exr_reader.h"

namespace dgm::formats {

/// Walks over the headers and refuses what would make OpenEXR take memory that the file cannot back: it makes room for
/// an attribute as large as its size claims (a string of 2 GB in a file of 2 KB) and for rows as wide as the window
/// says, before it reads either. Knows the standard attributes by their sizes, so that both walk over the same bytes.
/// Refuses tiles and deep pixels as well: geometry maps have neither.
/// @param file_bytes  the file's size
/// @param max_pixels  of one part
/// @param max_parts   number of parts
/// @param budget      bytes that the file's pixels may unpack to
/// @throws model::Error kExrUnreadable
void check_exr_headers(const std::filesystem::path& path, std::uint64_t file_bytes, std::uint64_t max_pixels,
                       int max_parts, std::uint64_t budget);

/// Checks the headers and gives the bytes that the pixels of the file may unpack to: zlib packs at most 1032 to 1, and
/// a file that promises more is lying.
/// @throws model::Error kFileMissing, kReadFailed, kExrUnreadable
[[nodiscard]] std::uint64_t exr_budget(const std::filesystem::path& path, const ExrReadLimits& limits);

}  // namespace dgm::formats
