// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/collapse_degenerate.h
// Removing faces without height where no neighbour has any either.
#pragma once
#include <cstdint>

#include "model/tri_mesh.h"

namespace dgm::bake {

/// Moves a vertex onto a neighbour, and so removes the faces at the edge between them, where the surface is no other
/// afterwards: both are at one place, or all faces at the vertex lie, and stay, within a line. The topology is kept
/// [Dey, Edelsbrunner, Guha, Nekhayev 1999: the link condition], and a border vertex moves along its border only.
/// Coordinates rounded to a coarse lattice leave such faces in thousands, which no map can separate.
///
/// `mesh` is one component as repair() makes it. Returns the number of faces removed.
std::uint64_t collapse_degenerate(model::TriMesh& mesh);

}  // namespace dgm::bake
