// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/flip_degenerate.h
// Removing faces without height by flipping their longest edge.
#pragma once
#include <cstdint>

#include "model/tri_mesh.h"

namespace dgm::bake {

/// A cap (a corner on, or within 1e-10 of, its longest edge) gives that edge to its neighbour, which is split at the
/// corner: the surface stays closed and moves by no more than the height. A face on whose longest edge nothing lies, or
/// whose flip would double an edge or make a thinner face, stays. Returns the number of flips.
std::uint64_t flip_degenerate(model::TriMesh& mesh);

}  // namespace dgm::bake
