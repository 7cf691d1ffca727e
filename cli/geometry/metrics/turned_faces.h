// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/metrics/turned_faces.h
// Finds triangles that face against their source: folds that a distance does not see (docs/design.md section 7).
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/spatial/closest_point.h"
#include "model/tri_mesh.h"

namespace dgm::bake {

/// As near as the nearest: distances to two source faces within this much of each other, in diagonals of the source,
/// are one (100 dB). On a crease, and between the sides of a sheet thinner than that, any of them counts.
inline constexpr double kTurnedTie = 1e-5;

/// Faces of `map` that are inverted against `source`, ascending.
///
/// A triangle with unit normal n and centre c is inverted if no source face with unit normal N, n . N > 0, comes as
/// near to c as the nearest source face of all (within `tie` diagonals of the source). Source faces without area do
/// not count, nor do map triangles without area or with corners that are not finite: the former have no side, the
/// latter are reported elsewhere. `index` must be built of the source. Deterministic whatever the number of threads.
/// @param least_cosine  requires n . N > this instead
/// @param either_side   of each face of `map`, 1 if -n will do as well; empty: of none
[[nodiscard]] std::vector<std::uint32_t> find_turned_faces(const ClosestPointIndex& index, const model::TriMesh& map,
                                                           double tie, double least_cosine = 0,
                                                           std::span<const char> either_side = {});

/// Faces beside a seam across which windings disagree, and their neighbours: what lies nearest to them may be the
/// source on the other side of the seam, which faces the other way. Empty if there is no such seam.
/// @param faces     over the points of the welded surface
/// @param reversed  of each point, 1 if a copy of it is reversed; or empty
[[nodiscard]] std::vector<char> faces_beside_reversed(std::span<const model::Face> faces,
                                                      std::span<const char> reversed);

/// How many there are, with a tie of kTurnedTie diagonals of the source.
/// @param index  of the source, if there is one already
/// @throws model::Error kInternal if the index cannot be built
[[nodiscard]] std::size_t count_turned_faces(const model::TriMesh& source, const model::TriMesh& map,
                                             const ClosestPointIndex* index = nullptr,
                                             std::span<const char> either_side = {});

}  // namespace dgm::bake
