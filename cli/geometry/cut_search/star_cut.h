// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/star_cut.h
// Cuts along which a sphere unfolds as an octahedron.
#pragma once
#include <cstddef>
#include <vector>

#include "geometry/cut/cut_graph.h"
#include "model/progress.h"

namespace dgm::bake {

/// Maps the component to the sphere (spherical_map.h), lays octahedra of evenly spread orientations on it and cuts
/// along four edges of each, from one corner to its neighbours [Praun, Hoppe 2003]: a star of four arms, equally long
/// on the sphere, that lay_square_border puts on the square by BorderShares::kEqualArms. The arms follow edges of the
/// mesh near the great arcs and touch nowhere but in the middle; orientations that leave no such way are left out.
///
/// @param component  closed, genus 0; must outlive the cuts
/// @return  how_many cuts at most
/// @throws model::Error as spherical_map does
[[nodiscard]] std::vector<CutGraph> star_cuts(const TriMesh& component, std::size_t how_many,
                                              const model::Progress& progress);

}  // namespace dgm::bake
