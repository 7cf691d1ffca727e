// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_part.h
// Reads the pixels of one part into the layers that it holds.
#pragma once
#include <ImfMultiPartInputFile.h>

#include <cstdint>
#include <filesystem>
#include <vector>

#include "exr/exr_plan.h"
#include "model/map_set.h"

namespace dgm::formats {

/// Fills the bytes of the part's layers, which have their types and shapes already.
/// @param number  which part of the file it is
/// @param budget  bytes that the layers may take; what they take is subtracted
/// @throws model::Error kMissingChannel if the part has another size, lacks a channel, or was saved with a type that
///         lost values; kExrUnreadable, at `path`, if a channel holds a number that its layer's type cannot, or the
///         budget is too small
void read_exr_part(Imf::MultiPartInputFile& file, int number, const PlannedPart& part,
                   std::vector<model::Chart>& charts, const std::filesystem::path& path, std::uint64_t& budget);

}  // namespace dgm::formats
