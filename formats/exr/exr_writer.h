// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_writer.h
// MapSet to OpenEXR, lossless (formats/SPEC.md section 5).
#pragma once
#include <filesystem>
#include <vector>

#include "exr/exr_files.h"
#include "model/map_set.h"

namespace dgm::formats {

struct ExrOptions {
    ExrLayout layout = ExrLayout::kAuto;
};

/// Writes all charts and layers with ZIP compression, so that read_exr gives back an equal MapSet, to the bit: `path`,
/// and beside it a file for each layer of another size (exr_side_path). Deterministic: the same MapSet and options give
/// the same bytes.
/// @return  the files written, `path` last; no other may stand in the way of their names
/// @throws model::Error kWriteFailed (all files are removed), kBadLayerShape as write_dgm and plan_exr
std::vector<std::filesystem::path> write_exr(const model::MapSet& maps, const std::filesystem::path& path,
                                             const ExrOptions& options = {});

}  // namespace dgm::formats
