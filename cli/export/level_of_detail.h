// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/level_of_detail.h
// Coarser triangles for an exported surface, as the runtime draws them.
#pragma once
#include <cstdint>
#include <filesystem>

#include "model/map_set.h"
#include "render/chart_surface.h"

namespace dgm::exporter {

/// Replaces the faces of `surface`, made of all charts of `maps`, by those of the runtime's reconstruct() with
/// lod_stride = `stride`: blocks of at least stride x stride quads become two triangles, borders keep all their
/// samples, so seams stay closed. Vertices without a face are dropped; grid, seam and border edges too, which name
/// vertices.
///
/// The runtime maps files: the shape of `maps` is written to `scratch` first.
/// @throws model::Error as formats::write_dgm; kBadValue if the runtime refuses the maps
void thin_by_stride(render::ChartSurface& surface, const model::MapSet& maps, std::uint32_t stride,
                    const std::filesystem::path& scratch);

}  // namespace dgm::exporter
