// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/flip_edge.h
// Giving two faces the other diagonal of their quad, with corner attributes and links kept.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/mesh/half_edges.h"

namespace dgm::bake {

/// True if the edge of h can be flipped without doubling another one.
[[nodiscard]] bool may_flip(std::span<const Face> faces, std::span<const std::uint32_t> opposite, std::uint32_t h);

/// Faces (p, q, r) of h = (p -> q) and (q, p, s) across become (p, s, r) and (q, r, s), and `opposite` is kept; h is
/// then p -> s. Corners take the attributes that r and s have in the other face. may_flip(h) must hold.
void flip_edge(TriMesh& mesh, std::vector<std::uint32_t>& opposite, std::uint32_t h);

}  // namespace dgm::bake
