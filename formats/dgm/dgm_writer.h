// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/dgm_writer.h
// MapSet to .dgm: HDF5 with the runtime's index in the user block (formats/SPEC.md).
#pragma once
#include <filesystem>

#include "model/map_set.h"

namespace dgm::formats {

/// Writes `maps` to exactly `path` (replacing it) and syncs it to disk. A temporary name and the rename are left to the
/// caller (atomic_file.h). The same MapSet gives the same bytes.
/// @throws model::Error kWriteFailed (the file is removed); kBadLayerShape if a layer's bytes do not fit its shape, a
///         name is empty, too long or used twice, or a number of charts or layers is beyond the format
/// Not thread-safe: the serial HDF5 library allows one thread at a time.
void write_dgm(const model::MapSet& maps, const std::filesystem::path& path);

}  // namespace dgm::formats
