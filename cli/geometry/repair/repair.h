// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/repair.h
// Turns the mesh of an importer into oriented manifold components in a normalised frame.
#pragma once
#include <vector>

#include "geometry/repair/repair_counts.h"
#include "model/tri_mesh.h"

namespace dgm::bake {

/// Normalised frame: p_source = centre + diagonal * p. Components have bounding-box diagonal <= 1.
struct Frame {
    model::Vec3d centre;
    double diagonal = 1;
};

struct RepairedMesh {
    Frame frame;
    /// Connected, oriented, manifold (edges with one or two faces, one fan a vertex, at most one edge between two
    /// vertices), every vertex used; in order of their first face in the source. One without an inside is opened.
    std::vector<model::TriMesh> components;
    RepairCounts counts;  ///< changes made
};

/// Repairs by gluing rather than by deleting: corners are joined where faces share an edge, so that non-manifold edges
/// and vertices come apart by themselves and every corner attribute survives.
///
///  1. faces with non-finite or out-of-range corners, faces that repeat a corner, and faces that stand twice (also with
///     opposite winding) are dropped;
///  2. vertices on open edges are welded, exactly first and then within 1e-3 of their shortest open edge, at most 1e-6
///     of the diagonal; vertices inside a surface are left as the file connects them, so two coincident sheets stay
///     two;
///  3. an edge of more than two faces is taken apart into pairs by the angle around it;
///  4. windings are made to agree; a closed component whose windings were mixed is turned outward; a component without
///     an inside is opened along a short curve, and `points` keeps which vertices are one (model/tri_mesh.h);
///  5. faces without height are flipped away where a neighbour can take their longest edge, collapsed where no
///     neighbour has height either, and dropped where a whole component has none.
///
/// @throws model::Error kNoFaces if nothing with an area is left
[[nodiscard]] RepairedMesh repair(const model::TriMesh& source);

}  // namespace dgm::bake
