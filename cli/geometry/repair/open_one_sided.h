// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/open_one_sided.h
// Opens a surface without an inside (a Moebius strip, a Klein bottle, a projective plane) so that what is left has two
// sides.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/repair/glue_edges.h"

namespace dgm::bake {

/// Chooses a short curve such that the faces of a connected surface, opened along it, can agree in their windings, and
/// sets `turned` of each accordingly: neighbours that disagree then meet on the curve. The opened surface is connected.
///
/// Shortest paths from the open border (or from a point, where there is none: the best of some points far apart) and
/// the edges whose loops over them are longest leave a tree of faces [Erickson, Whittlesey 2005]; the windings agree
/// along the tree. Then a face is turned as long as that shortens the curve.
///
/// @param faces    the faces of the surface, in the order in which a walk from the first one meets them
/// @param partner  glued half-edges, as glue_edges() returns them
void open_one_sided(const FaceSoup& soup, std::span<const std::uint32_t> faces, std::span<const std::uint32_t> partner,
                    std::vector<char>& turned);

}  // namespace dgm::bake
