// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/ring_cut.h
// Cuts along which a ring unrolls: skirts, sleeves, tubes.
#pragma once
#include <cstddef>
#include <vector>

#include "geometry/cut/cut_graph.h"

namespace dgm::bake {

/// True for a surface with two sides, no handles and two border loops.
[[nodiscard]] bool is_ring(const TriMesh& component);

/// Paths from loop to loop, as cuts that lay_square_border() puts on opposite sides of the square by
/// BorderShares::kLoopsOnM: the shortest of all first, then the shortest from each of `how_many` - 1 places spread
/// evenly over the longer loop. They follow edges, and touch each loop at one vertex.
/// @param component  must outlive the cuts
/// @return different cuts; fewer where places have no such path, none for a surface that is no ring
[[nodiscard]] std::vector<CutGraph> ring_cuts(const TriMesh& component, std::size_t how_many);

}  // namespace dgm::bake
