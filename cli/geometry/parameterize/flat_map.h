// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/flat_map.h
// The map of a flat disk: its own plane.
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "model/tri_mesh.h"

namespace dgm::bake {

/// Positions in the plane of a surface that lies in one, without turning over: the isometric map, which no energy can
/// better. For surfaces with needles only (a face 1,000 times as long as high), of which triangulated polygons with
/// thousands of corners are full and on which solvers stall or lose digits; nothing for all others.
/// @param positions  normalised frame; all used by `faces`
/// @return one point per position, every face positive by exact predicates; the whole may overlap itself
[[nodiscard]] std::optional<std::vector<model::Vec2d>> flat_needle_map(std::span<const model::Vec3d> positions,
                                                                       std::span<const model::Face> faces);

}  // namespace dgm::bake
