// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/glue_edges.h
// Glues a soup's faces along their edges, makes their windings agree, and builds one mesh a component.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/repair/face_soup.h"

namespace dgm::bake {

/// Pairs the half-edges of each edge: the two of a manifold edge, and by angle those of an edge of more faces.
/// @return  the glued half-edge of each half-edge, of either direction; kNone where the surface is open
[[nodiscard]] std::vector<std::uint32_t> glue_edges(const FaceSoup& soup, RepairCounts& counts);

/// The connected surfaces of the glued faces, and which faces have to be turned.
struct Orientation {
    std::vector<std::uint32_t> component;  ///< of each face; numbered by their first faces
    std::vector<char> turned;              ///< of each face: 1 if its winding has to be reversed
    std::uint32_t component_count = 0;
    std::vector<char> one_sided;  ///< of each component: 1 if it has no inside (open_one_sided.h)
    /// Of each half-edge on the curve along which such a component is opened, the glued one that it parts from; kNone
    /// elsewhere. Empty if every component has two sides.
    std::vector<std::uint32_t> across;
};

/// Makes the windings of each component agree. A closed component whose windings were mixed is turned outward; any
/// other keeps the winding of the larger area. A component without an inside is opened along a short curve.
[[nodiscard]] Orientation orient(const FaceSoup& soup, std::span<const std::uint32_t> partner, RepairCounts& counts);

/// One mesh for each component, with the source's corner attributes. Corners are one vertex where gluing joins them, so
/// that non-manifold vertices come apart; an edge that joins the same two vertices as another gets a vertex in its
/// middle. Where a component without an inside is opened, the vertices of both sides have one entry in `points`, and no
/// other edge joins the points of an edge of that curve.
[[nodiscard]] std::vector<TriMesh> build_components(const TriMesh& source, const FaceSoup& soup,
                                                    std::span<const std::uint32_t> partner,
                                                    const Orientation& orientation, RepairCounts& counts);

}  // namespace dgm::bake
