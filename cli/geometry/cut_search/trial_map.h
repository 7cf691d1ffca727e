// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/trial_map.h
// Predicts the worth of a cut at a small part of the cost of baking it.
#pragma once
#include <cstdint>
#include <vector>

#include "geometry/cut/disk.h"
#include "geometry/parameterize/multilevel_map.h"
#include "geometry/parameterize/square_border.h"
#include "model/progress.h"

namespace dgm::bake {

struct TrialMap {
    Disk disk;              ///< split as the border needed it
    std::vector<Vec2d> uv;  ///< per vertex of `disk`
    double rms = 0;         ///< predicted error of the m x n grid, in the mesh's units
};

/// Lays the border, maps by multilevel_map.h (damped_reweight.h where that has no start) and predicts the error of
/// the m x n grid surface: the distance of the vertices and face centres, by their share of the area, to the quad of
/// the grid that the map puts them in. The quad is near the point, so no search is needed; the true distance is at most
/// that.
///
/// @throws model::Error kGridTooSmall, kMapInvalid if faces are flipped or samples uncovered, kInterrupted
[[nodiscard]] TrialMap make_trial_map(Disk disk, std::uint32_t m, std::uint32_t n, std::uint32_t rotation,
                                      const MultilevelOptions& options, const model::Progress& progress,
                                      BorderShares shares = BorderShares::kByLength);

}  // namespace dgm::bake
