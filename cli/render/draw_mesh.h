// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/draw_mesh.h
// Any mesh as vertices with one normal each, few enough for a page.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/tri_mesh.h"

namespace dgm::render {

struct DrawMesh {
    std::vector<model::Vec3d> positions;
    std::vector<model::Vec3d> normals;  ///< unit, one a position
    std::vector<model::Face> faces;
    /// (vertex, vertex of the mesh it was made of), one entry for each corner of the mesh's faces that are drawn from.
    std::vector<std::array<std::uint32_t, 2>> origins;
    bool simplified = false;  ///< vertices were put together
};

/// Vertices are split where normals differ (the mesh's own, else smooth up to 50 degrees). If there are more than
/// `most`, those in one cell of a cubic lattice become one [Rossignac and Borrel 1993], apart by the side they look to,
/// so that thin sheets keep both sides. Any mesh will do: no topology is asked for.
/// Faces with an index out of range or a position that is not finite are left out.
[[nodiscard]] DrawMesh draw_mesh(const model::TriMesh& mesh, std::size_t most);

}  // namespace dgm::render
