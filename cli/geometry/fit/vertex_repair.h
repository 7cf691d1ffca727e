// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/vertex_repair.h
// Repairs inverted faces one sample at a time, judged by normals.
#pragma once
#include <span>

#include "geometry/fit/matches.h"

namespace dgm::bake {

/// Sampling leaves a few inverted faces, where the map is sheared and beside cuts. The samples of each face with
/// normal . source normal < upright  try places around them on the source, and take one where the faces around them
/// look better and cover the source's vertices as well. Classes marked `fixed` stay. Repeats while it helps, some
/// rounds at most; `matches` is kept up to date.
/// @return  true if a sample moved
bool repair_by_vertex(const LinkedSurface& source, WeldedGrid& grid, Matches& matches, std::span<const char> fixed,
                      double upright);

/// The same, once, for the faces given.
bool repair_by_vertex(const LinkedSurface& source, WeldedGrid& grid, Matches& matches, std::span<const char> fixed,
                      std::span<const std::uint32_t> faces);

}  // namespace dgm::bake
