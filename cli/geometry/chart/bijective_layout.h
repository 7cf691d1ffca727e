// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/bijective_layout.h
// Descent of a free-border map that may not overlap itself.
#pragma once
#include <vector>

#include "geometry/chart/free_chart.h"
#include "geometry/parameterize/slim.h"

namespace dgm::bake {

/// Lowers `energy` as descend_flip_free() does with a free border, and keeps the map one to one: the plane around the
/// chart is triangulated as far as a box, and the triangles outside, each at rest in its present shape and of small
/// weight, may not flip either [Jiang, Schaefer, Panozzo 2017]. They are made anew every few Newton steps.
/// @param start  a one-to-one map, every face counter-clockwise; scaled to the surface's area first
/// @return a one-to-one map; its border is a simple polygon up to the rounding of exact predicates
/// @throws model::Error kMapInvalid if `start` is not one to one, kInterrupted
/// Deterministic if `triangulate` is. Cost: some tens of factorizations of 2V unknowns.
[[nodiscard]] std::vector<Vec2d> descend_bijective(const DiskView& disk, std::vector<Vec2d> start,
                                                   FlipFreeEnergy energy, const Triangulate& triangulate,
                                                   const model::Progress& progress);

}  // namespace dgm::bake
