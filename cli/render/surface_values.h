// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/surface_values.h
// Values that colour the reconstruction: its distance from the source, and the distortion of the map.
#pragma once
#include <vector>

#include "geometry/metrics/reconstruction.h"
#include "geometry/spatial/closest_point.h"
#include "model/map_set.h"

namespace dgm::render {

/// One number a vertex of the reconstruction; NaN where no face uses it.
struct SurfaceValues {
    /// Signed distance to the source in source units, positive outside (on the side that the normal points to): the
    /// largest in size among the vertex and the middles of its faces. Seam copies agree.
    std::vector<double> distance;
    /// log2 of surface area per area of the grid, relative to the chart's mean: 1 is twice as much surface a sample.
    std::vector<double> area;
    /// log2 of the quasi-conformal dilatation s1 / s2 >= 1, the ratio of the map's singular values; 0 is conformal.
    std::vector<double> angle;
};

/// Distortions are those from the grid, one step a unit in both directions, to the surface: means over the faces around
/// a vertex by area. Faces without area in the grid are left out. `chart` must be what `surface` was made of.
[[nodiscard]] SurfaceValues surface_values(const model::Chart& chart, const bake::Reconstruction& surface,
                                           const bake::ClosestPointIndex& source);

/// Per vertex of the source, how far the reconstruction is away: the largest in size among the vertex and a lattice
/// of points on its faces (about 200 000 in all, at most 136 a face), with the sign as above (negative: the
/// reconstruction is inside). Faces that the map leaves out show here alone.
[[nodiscard]] std::vector<double> source_distances(const model::TriMesh& source, const model::TriMesh& map);

}  // namespace dgm::render
