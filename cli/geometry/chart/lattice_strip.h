// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/lattice_strip.h
// The strip of triangles between the lattice and the border of a free chart.
#pragma once
#include "geometry/chart/free_chart.h"

namespace dgm::bake {

/// Needs mask (samples covered by the map), border_uv and representative; thins the mask to the samples that quads may
/// use, and fills `strip`. Quads that a border edge enters, and samples within 0.15 cells of the border, are left out.
///
/// @return border samples, by their place on the border, at the ends of strip edges that are more than one edge of the
///     welded surface or none, and that no flip removes: more border samples beside them may
/// @throws model::Error kMapInvalid if the region cannot be triangulated
[[nodiscard]] std::vector<std::uint32_t> join_lattice_to_border(SampledChart& chart, const Triangulate& triangulate);

}  // namespace dgm::bake
