// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/component_search.h
// Searches the best cut of a mesh on the mesh itself, whatever its size.
#pragma once
#include "geometry/cut/cut_graph.h"
#include "geometry/cut_search/cut_search.h"
#include "model/progress.h"

namespace dgm::bake {

struct ComponentCut {
    CutSearchResult result;  ///< on the grid of the options
    CutGraph cut;            ///< along edges
    bool straight = false;   ///< result.disk runs across faces where the cut is jagged
};

/// Half width of the surroundings in which paths are pulled straight, in mean edges of the mesh searched.
inline constexpr double kStraightReach = 1;

/// Whether a cut is tried while no map was found: a body with hundreds of limbs has none until most of them are cut.
/// The more limbs are joined to it, the more are joined before the next trial, up to 16.
[[nodiscard]] bool is_worth_a_trial(int limbs);

/// Length of the cut that opened a disk.
[[nodiscard]] double length_of_cut(const Disk& disk);

/// As search_cut(), without simplification: a ring's cuts alone, if they are asked for; else the cut is augmented,
/// branches are dropped, and rotations, stars, hidden ways and straight paths are tried, in that order.
/// @param component  must outlive the result
/// @throws model::Error  the reason of the first failure if no cut gave a valid map
[[nodiscard]] ComponentCut search_component(const TriMesh& component, const CutSearchOptions& options,
                                            const model::Progress& progress);

}  // namespace dgm::bake
