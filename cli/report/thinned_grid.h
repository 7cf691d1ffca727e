// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/thinned_grid.h
// Fewer triangles of a chart for looking at, on samples of the grid itself and without cracks.
#pragma once
#include <cstdint>
#include <vector>

#include "geometry/metrics/reconstruction.h"
#include "model/map_set.h"

namespace dgm::report {

/// Triangles over the vertices of `full`, wound like its own. Blocks of stride x stride quads that are all there become
/// two triangles; where such a block meets the border of the chart, a seam, or a block that is not, it keeps every
/// sample of that side and is a fan around its middle. So seam copies stay side by side, and nothing gapes. Border
/// strips and incomplete blocks stay as they are. stride 1 gives full.mesh.faces.
[[nodiscard]] std::vector<model::Face> thinned_faces(const model::Chart& chart, const bake::Reconstruction& full,
                                                     std::uint32_t stride);

}  // namespace dgm::report
