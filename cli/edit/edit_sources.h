// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/edit_sources.h
// Reads what a painter has saved, and offers it to the map.
#pragma once
#include <filesystem>

#include "edit/painted_map.h"

namespace dgm::edit {

/// By what `source` is: a .dgm, a folder of plain maps (or its JSON, or one of its pictures), or an EXR of layers.
/// @throws model::Error as the functions below; kFileMissing
void offer_edit(PaintedMap& map, const std::filesystem::path& source);

/// The channels that are there, of the EXR that dgm-export writes; saved as half or as whole numbers, too.
/// @throws model::Error as formats::read_exr_planes
void offer_exr(PaintedMap& map, const std::filesystem::path& exr);

/// A .dgm of the same grids whose layers somebody has changed, such as by h5py; its hashes need not fit.
/// @throws model::Error as formats::read_changed_dgm; kEditUnrelated if charts or layers are others
void offer_dgm(PaintedMap& map, const std::filesystem::path& dgm);

/// Plain maps (export/plain_maps.h): a folder, its JSON, or one picture that the JSON beside it lists. An EXR holds the
/// numbers themselves; in a PNG black and white stand for 0 and 1, or for the least and largest number of the JSON.
/// Maps are compared with those that dgm-export writes of the map now.
/// @throws model::Error kEditUnrelated: another grid, another size, colours where one number is meant, or maps that
///         were resampled; kUsage for two pictures of one map; kReadFailed, kImageUnreadable, kExrUnreadable
void offer_plain_maps(PaintedMap& map, const std::filesystem::path& maps);

/// True if a JSON of plain maps beside `picture` lists a file of its name, whatever the ending.
[[nodiscard]] bool is_plain_map(const std::filesystem::path& picture);

}  // namespace dgm::edit
