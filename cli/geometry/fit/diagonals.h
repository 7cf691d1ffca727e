// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/diagonals.h
// Chooses how the quads of a chart are split while it is fitted.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/chart/sampled_chart.h"
#include "geometry/fit/matches.h"
#include "geometry/fit/welded_grid.h"
#include "geometry/spatial/closest_point.h"

namespace dgm::bake {

/// Each quad takes the diagonal with the smaller squared distance to the source points over it and of its own middle to
/// the source. One that the welded surface has as an edge already is not taken: it would be no manifold any more. The
/// caller links the grid anew.
/// @return  per face of the grid: its quad is split the other way now
[[nodiscard]] std::vector<char> fit_diagonals(SampledChart& chart, const WeldedGrid& grid, const Matches& matches,
                                              const LinkedSurface& source);

/// Splits the quads of inverted faces the other way, where that does not fold (with an index of the source: where fewer
/// triangles are inverted) and its edge is no edge yet. The caller links the grid anew.
/// @return  true if one is split the other way
[[nodiscard]] bool flip_diagonals(SampledChart& chart, const WeldedGrid& grid, std::span<const std::uint32_t> faces,
                                  const ClosestPointIndex* source);

}  // namespace dgm::bake
