// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cgal/exact_geodesics.h
// Exact distances along a triangle mesh, by CGAL's Surface_mesh_shortest_path: a reference for other methods.
//
// [Xin, Wang 2009] Improving Chen and Han's algorithm on the discrete geodesic problem. ACM TOG 28(4).
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "model/vec.h"

namespace dgm::bake {

/// For each vertex the length of the shortest path over the faces from vertex `source`; infinity where it is longer
/// than `radius` or there is none. Faces without area, and faces that would make an edge of three, are left out.
///
/// Only faces that a path of that length can reach are visited, so the cost depends on them (some 10 000 a second).
/// @throws model::Error kInternal if an index is out of range or CGAL gives up
[[nodiscard]] std::vector<double> exact_geodesics(std::span<const model::Vec3d> positions,
                                                  std::span<const model::Face> faces, std::uint32_t source,
                                                  double radius);

}  // namespace dgm::bake
