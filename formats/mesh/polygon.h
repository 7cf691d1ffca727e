// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/polygon.h
// Splitting of a polygon in space into triangles.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "model/vec.h"

namespace dgm::formats {

/// Corners of a triangle as indices into the polygon.
using CornerTriple = std::array<std::uint32_t, 3>;

/// Appends size - 2 triangles of the polygon's winding to `out`.
///
/// Ear clipping [Meisters 1975] in the coordinate plane nearest to the polygon's own (Newell normal), shortest diagonal
/// first. A quad that is convex or has no plane is split along corners 0 and 2. Where no ear is left (self-crossing or
/// flat polygons) the rest becomes a fan.
/// @return false if a fan stood in for ears: also for polygons with a point that is not finite, and when the search
///         would take too long (more than 2^28 point tests)
/// @param corners  at least 3 points
[[nodiscard]] bool triangulate_polygon(std::span<const model::Vec3d> corners, std::vector<CornerTriple>& out);

}  // namespace dgm::formats
