// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/refine.h
// The same surface with more faces.
#pragma once
#include <cstddef>

#include "geometry/mesh/half_edges.h"

namespace dgm::bake {

/// Halves the longest edge until there are at least `faces` faces, and keeps flat places Delaunay by flips [Lawson
/// 1977], so that needles there go. Elsewhere no angle becomes less than half of the least one in `mesh` [Rivara 1984].
/// A place is flat where another diagonal would move the surface by no more than 2e-7 of its diagonal and leave corner
/// attributes as they are. These are interpolated.
/// @param mesh  an oriented manifold without `points`
/// Deterministic: of edges of one length the one with the lower vertices goes first. O(faces log faces).
[[nodiscard]] TriMesh refine(TriMesh mesh, std::size_t faces);

}  // namespace dgm::bake
