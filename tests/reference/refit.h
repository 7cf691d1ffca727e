// SPDX-License-Identifier: GPL-3.0-or-later
// tests/reference/refit.h
// Moves the vertices of an irregular mesh, and flips its edges, to where a source lies closest.
#pragma once
#include "geometry/metrics/surface_error.h"
#include "geometry/spatial/closest_point.h"
#include "model/tri_mesh.h"

namespace dgm::bench {

struct Refitted {
    model::TriMesh mesh;
    bake::SurfaceError before, after;  ///< by a tenth of the usual points
    int rounds = 0, flips = 0;         ///< that were kept
};

/// Rounds of two steps each: all vertices but those of borders move by tangent-plane least squares, points of the
/// source to the mesh and points of the mesh to the source; then edges flip where that lowers the squared distances of
/// the points beside them. A step is kept only if the measured two-way rms falls; none inverts a face against what it
/// was, and flips keep the surface a manifold. The same bits whatever the number of threads.
/// @param mesh   manifold, oriented, with borders or without
/// @param index  of the source
[[nodiscard]] Refitted refit(const model::TriMesh& source, const bake::ClosestPointIndex& index, model::TriMesh mesh,
                             int rounds = 8);

}  // namespace dgm::bench
