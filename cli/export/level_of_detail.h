// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/level_of_detail.h
// Coarser triangles for an exported surface, as the runtime draws them.
#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

#include "model/map_set.h"
#include "model/vec.h"

namespace dgm::exporter {

/// The faces of each chart by the runtime's reconstruct() with lod_stride = `stride`: blocks of at least stride x
/// stride quads become two triangles, borders keep all their samples, so seams stay closed. They name the chart's grid
/// samples, then its border samples.
///
/// The runtime maps files: the shape of `maps` is written to `scratch` first.
/// @throws model::Error as formats::write_dgm; kBadValue if the runtime refuses the maps
[[nodiscard]] std::vector<std::vector<model::Face>> faces_at_stride(const model::MapSet& maps, std::uint32_t stride,
                                                                    const std::filesystem::path& scratch);

}  // namespace dgm::exporter
