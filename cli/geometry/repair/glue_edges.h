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
};

/// Makes the windings of each component agree. A closed component whose windings were mixed is turned outward; any
/// other keeps the winding of the larger area.
/// @throws model::Error kNonOrientable with the first face where the sides meet
[[nodiscard]] Orientation orient(const FaceSoup& soup, std::span<const std::uint32_t> partner, RepairCounts& counts);

/// One mesh for each component, with the source's corner attributes. Corners are one vertex where gluing joins them, so
/// that non-manifold vertices come apart; an edge that joins the same two vertices as another gets a vertex in its
/// middle.
[[nodiscard]] std::vector<TriMesh> build_components(const TriMesh& source, const FaceSoup& soup,
                                                    std::span<const std::uint32_t> partner,
                                                    const Orientation& orientation, RepairCounts& counts);

}  // namespace dgm::bake
