// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/hidden_cut.h
// Cuts that open a surface as a given one does, along less visible ways.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/cut/cut_graph.h"

namespace dgm::bake {

/// For CutGraph::weigh(): 1 for an edge in plain view, falling to 0.1 where the surface is hidden (spatial/exposure.h)
/// and in creases that look inward.
/// @param opposite  of the mesh's half-edges
[[nodiscard]] std::vector<double> hiding_factors(const TriMesh& mesh, std::span<const std::uint32_t> opposite);

/// A path of a cut between two of its nodes.
struct CutWay {
    std::uint32_t from, to;                 ///< vertices
    std::vector<std::uint32_t> half_edges;  ///< one of each edge, in order
    double cost;
    double saved;  ///< by the cheapest way between the same nodes
};

/// Paths of the cut that have a way cheaper by a few percent, by the costs of CutGraph::weigh(); the greatest saving
/// first. Paths about handles and from border to border are left out: another way need not open the surface.
[[nodiscard]] std::vector<CutWay> hideable_ways(const CutGraph& cut);

/// Cuts the cheapest way between the same nodes instead, if it is cheaper and crosses nothing; the surface stays one
/// disk.
void hide_way(CutGraph& cut, const CutWay& way);

inline constexpr int kSeamPoints = 1000;

/// Mean exposure along the seams of `disk`, by length, from evenly spaced points; 0 without seams.
/// @param component  that the disk was cut from, whose parts hide the seams
/// @param points  at least 1
[[nodiscard]] double seam_exposure(const Disk& disk, const TriMesh& component, int points = kSeamPoints);

}  // namespace dgm::bake
