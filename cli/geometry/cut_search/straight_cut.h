// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/straight_cut.h
// A cut that runs across faces, not only along edges.
#pragma once
#include "geometry/cut/cut_graph.h"

namespace dgm::bake {

/// Opens the surface along `cut` with each path between two nodes pulled straight: the shortest way through faces near
/// it [Lanthier, Maheshwari, Sack 1997: shortest paths over points put on the edges], whose crossings then slide along
/// their edges to where it is shortest. Nodes stay, paths do not touch but at nodes, and none gets longer. Paths that
/// would pass a handle on its other side stay as they are.
///
/// Edges that a path crosses are split there, so the surface stays the same: vertices of the component keep their
/// numbers as weld ids, new ones have later ones.
///
/// @param reach  how far from its path of edges a straight one may run, in mean edge lengths of that path
[[nodiscard]] Disk open_straight(const CutGraph& cut, double reach);

}  // namespace dgm::bake
