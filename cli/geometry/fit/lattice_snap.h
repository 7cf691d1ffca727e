// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/lattice_snap.h
// Fitted positions on the lattice of u16 storage.
#pragma once
#include <cstddef>
#include <span>

#include "geometry/fit/inverted_faces.h"
#include "geometry/fit/matches.h"
#include "geometry/fit/normal_equations.h"

namespace dgm::bake {

/// Puts the classes of grid samples on the lattice, where the fit suffers least, and repairs the faces that this
/// inverted. Border samples of a free chart (beyond `grid_count`) are stored as f32 and stay. `grid` and `matches` are
/// kept up to date.
/// @param equations  with the rows of the fit as the grid lies
void snap_to_lattice(const Lattice& lattice, const NormalEquations& equations, std::span<const Freedom> freedom,
                     std::size_t grid_count, const LinkedSurface& source, WeldedGrid& grid, Matches& matches,
                     InvertedFaces& inverted);

}  // namespace dgm::bake
