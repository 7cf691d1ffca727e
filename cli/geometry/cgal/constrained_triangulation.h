// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cgal/constrained_triangulation.h
// Constrained Delaunay triangulation of a plane region with holes.
#pragma once
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "model/vec.h"

namespace dgm::bake {

/// Delaunay triangles, constrained to the given edges, that an odd number of constraints separates from the outside:
/// between an outline and its holes. Counter-clockwise, indices into `points`, in a fixed order.
/// @throws model::Error kMapInvalid if points coincide or constraints cross
[[nodiscard]] std::vector<model::Face> constrained_triangulation(
    std::span<const model::Vec2d> points, std::span<const std::pair<std::uint32_t, std::uint32_t>> constraints);

}  // namespace dgm::bake
