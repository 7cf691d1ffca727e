// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/cut_transfer.h
// A cut found on a simplified mesh, carried to the mesh it was simplified from.
#pragma once
#include <cstdint>
#include <optional>
#include <span>

#include "geometry/cut/cut_graph.h"
#include "geometry/simplify/simplify.h"

namespace dgm::bake {

/// Marks on `fine` the cut of `coarse`, whose vertex v is vertex original[v] of the fine mesh. Every coarse edge
/// becomes a shortest path of its own, and paths do not touch but at nodes; where there is no room for that, the cut
/// comes through the collapses (cut_carry.h), and nodes may move or part. Then each path between two nodes is pulled
/// straight within a corridor about it, whose half width is the coarse path's mean edge length, unless it would pass a
/// handle on its other side.
///
/// @param simplified  how the coarse mesh was made of the fine one
/// @return  false, and marks unspecified, if the coarse cut does not open its own mesh into one disk
[[nodiscard]] bool transfer_cut(const CutGraph& coarse, std::span<const std::uint32_t> original,
                                const Simplified& simplified, CutGraph& fine);

/// The rotation that puts the border of `fine` on an m x n grid where `rotation` puts that of `coarse` on its
/// coarse_m x coarse_n grid; nothing if the first path of the coarse border has no counterpart.
[[nodiscard]] std::optional<std::uint32_t> transfer_rotation(const Disk& coarse, std::uint32_t coarse_m,
                                                             std::uint32_t coarse_n, std::uint32_t rotation,
                                                             std::span<const std::uint32_t> original, const Disk& fine,
                                                             std::uint32_t m, std::uint32_t n);

}  // namespace dgm::bake
