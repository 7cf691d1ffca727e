// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_writer.h
// MapSet to OpenEXR, lossless (formats/SPEC.md section 5).
#pragma once
#include <filesystem>

#include "model/map_set.h"

namespace dgm::formats {

enum class ExrLayout {
    kAuto,       ///< one part for everything grid-sized, further parts only where sizes differ
    kMultipart,  ///< one part a layer, named like it
};

struct ExrOptions {
    ExrLayout layout = ExrLayout::kAuto;
};

/// Writes all charts and layers to exactly `path` with ZIP compression, so that read_exr gives back an equal MapSet, to
/// the bit. Deterministic: the same MapSet and options give the same bytes.
/// @throws model::Error kWriteFailed (the file is removed), kBadLayerShape as write_dgm
void write_exr(const model::MapSet& maps, const std::filesystem::path& path, const ExrOptions& options = {});

}  // namespace dgm::formats
