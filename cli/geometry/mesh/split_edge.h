// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/split_edge.h
// Putting vertices into edges, with every corner attribute interpolated and the links kept.
#pragma once
#include <cstdint>
#include <vector>

#include "geometry/mesh/half_edges.h"

namespace dgm::bake {

/// Result of splitting the face of half-edge h = (a -> b) at vertex n: h is now a -> n; `second` is n -> b in the new
/// face; the half-edge that was b -> c has moved to the new face.
struct FaceSplit {
    std::uint32_t second, moved_from, moved_to;
};

/// Splits one face at vertex `n`, which lies at parameter t in (0, 1) of half-edge h. Links are the caller's.
FaceSplit split_face(TriMesh& mesh, std::uint32_t h, std::uint32_t n, double t);

/// The vertex put into an edge; on a cut edge its twin on the other side, else kNone.
struct NewVertices {
    std::uint32_t vertex, twin = kNone;
    std::uint32_t first = kNone;  ///< the half-edge that now runs from the edge's origin to `vertex`
};

/// Splits edge h at t and keeps `opposite`. With `mate` given (links across a cut, for half-edges without an opposite),
/// the edge across the cut is split at the mirrored place by a vertex of its own at the same position.
/// @param same_way  the edge across the cut runs in the direction of h: there the surface was opened to have two sides
NewVertices split_edge(TriMesh& mesh, std::vector<std::uint32_t>& opposite, std::uint32_t h, double t,
                       std::vector<std::uint32_t>* mate = nullptr, bool same_way = false);

/// Splits in the middle every edge but the first of those that join the same two vertices. `partner` gives the glued
/// half-edge of each (kNone on a border). Returns how many were split.
std::uint64_t split_repeated_edges(TriMesh& mesh, std::vector<std::uint32_t>& partner);

}  // namespace dgm::bake
