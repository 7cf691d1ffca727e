// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/surface_sample.h
// Names a point of a mesh's surface by its face and barycentric coordinates.
#pragma once
#include <cstdint>

#include "geometry/mesh/half_edges.h"

namespace dgm::bake {

/// A point of the surface: a face of the mesh and barycentric coordinates in it.
struct SurfaceSample {
    std::uint32_t face = kNone;
    double b[3] = {0, 0, 0};
};

/// Position of a sample on the surface.
[[nodiscard]] inline Vec3d position_at(const TriMesh& mesh, const SurfaceSample& s) {
    const Face& f = mesh.faces[s.face];
    return mesh.positions[f[0]] * s.b[0] + mesh.positions[f[1]] * s.b[1] + mesh.positions[f[2]] * s.b[2];
}

}  // namespace dgm::bake
