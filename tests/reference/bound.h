// SPDX-License-Identifier: GPL-3.0-or-later
// tests/reference/bound.h
// The least error that triangles can have on a smooth surface.
#pragma once
#include <cstddef>

#include "model/tri_mesh.h"

namespace dgm::bench {

/// Root mean square distance of the best surface of `triangles` triangles, in units of the mesh [Nadler 1986, Piecewise
/// linear best L2 approximation on triangulations; D'Azevedo, Simpson 1991].
///
/// With q1, q2, q3 the second fundamental form of the edges of a triangle, s their sum and p the sum of their squares,
/// its distance to the surface is (q1 l1 l2 + q2 l2 l3 + q3 l3 l1) / 2 in barycentric coordinates l; moved by its mean,
/// its mean square is (p / 180 - s^2 / 720) / 4, and s^2 - 2 p = 16 K a^2, K the Gaussian curvature and a the area. The
/// least of it is |K| a^2 / 180 where K > 0 (all q alike), and |K| a^2 / 90 where K < 0 (s = 0: not moved at all). With
/// areas in the best proportion, as (c |K|)^(-1/3), the mean square of the whole is
///   (integral of (c |K|)^(1/3) dA)^3 / (triangles^2 A).
///
/// A limit for many triangles on a smooth surface: not a strict bound for few, and of no meaning for facets and
/// creases. Curvature is that of the normals at the vertices, face by face: the mesh has to be fine and smooth.
[[nodiscard]] double least_rms(const model::TriMesh& mesh, std::size_t triangles);

}  // namespace dgm::bench
