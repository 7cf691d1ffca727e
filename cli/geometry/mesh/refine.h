// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/refine.h
// The same surface with more faces.
#pragma once
#include <cstddef>

#include "geometry/mesh/half_edges.h"

namespace dgm::bake {

/// Halves the longest edge until there are at least `faces` faces. Corner attributes are interpolated. No angle becomes
/// less than half of the least one in `mesh` [Rivara 1984]: needles stay needles.
/// @param mesh  an oriented manifold without `points`
/// Deterministic: of edges of one length the one with the lower vertices goes first. O(faces log faces).
[[nodiscard]] TriMesh refine(TriMesh mesh, std::size_t faces);

}  // namespace dgm::bake
