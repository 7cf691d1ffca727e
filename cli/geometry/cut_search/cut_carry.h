// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/cut_carry.h
// A cut taken through the collapses of a simplification, one at a time.
#pragma once
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "geometry/cut/cut_graph.h"
#include "geometry/simplify/simplify.h"

namespace dgm::bake {

/// Edges of the fine mesh that open it as `coarse` opens the simplified one, as pairs of vertices, lower one first, in
/// ascending order.
///
/// Collapses are taken back, last one first. Where a vertex comes apart into `kept` and `removed`, the edges that only
/// `removed` has now move to it, and the edge between the two joins the cut if the cut goes on at `kept`: the network
/// stays the same but for a deformation, whatever the genus, so the fine mesh becomes a disk if the coarse one does.
/// Nodes of four paths and more may part. The paths are crooked.
///
/// @param original  of compact(): the fine vertex that each coarse vertex is
/// @param fine  read only: the mesh that was simplified, unmarked
[[nodiscard]] std::vector<std::pair<std::uint32_t, std::uint32_t>> carry_cut(const CutGraph& coarse,
                                                                             std::span<const std::uint32_t> original,
                                                                             const Simplified& simplified,
                                                                             const CutGraph& fine);

}  // namespace dgm::bake
