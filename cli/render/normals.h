// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/normals.h
// Shading normals for meshes that bring none.
#pragma once
#include <vector>

#include "model/tri_mesh.h"

namespace dgm::render {

/// Three unit normals a face: the angle-weighted mean over the faces around the corner's position that turn less than
/// `crease_degrees` from this face [Thuermer and Wuethrich 1998]. Vertices at one and the same position count as one,
/// so seam copies shade alike. Faces without area get (0, 0, 1) unless a neighbour helps. Cost O(faces * valence), with
/// vertices of more than 64 faces averaged without regard to creases.
[[nodiscard]] std::vector<model::Vec3d> smooth_corner_normals(const model::TriMesh& mesh, double crease_degrees);

}  // namespace dgm::render
