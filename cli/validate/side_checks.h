// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/side_checks.h
// Checks which side of the surface faces where two sides meet: windings along seams, the layer `reversed`.
#pragma once
#include "validate/finding_list.h"
#include "validate/surface.h"

namespace dgm::validate {

/// Neighbours wind alike, or, across a seam whose copies are reversed (SPEC.md section 3.5), against each other. With
/// the layer `reversed` a fault is DGM2016, without it DGM2006.
/// @param oriented  what measure_topology() says of the welded surface
void check_sides(const Surface& s, bool oriented, FindingList& findings);

/// True if two copies of one point have the normals that SPEC.md section 3.5 asks for: opposite where one is reversed.
[[nodiscard]] bool opposite_normals(const Surface& s, std::size_t a, std::size_t b);

}  // namespace dgm::validate
