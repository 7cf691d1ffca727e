// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/limb_cut.h
// A cut to the tips of all limbs.
#pragma once
#include <cstddef>
#include <optional>

#include "geometry/cut/cut_graph.h"
#include "geometry/cut_search/cut_search.h"
#include "model/progress.h"

namespace dgm::bake {

/// A short cut that opens the component, and the shortest path to it from the tip of each limb: the point farthest from
/// the cut is joined to it, again and again. Ways to tips are long and those to the points between them are not, so the
/// limbs end where the next way is shorter than the last one by the largest factor.
///
/// @param component  must outlive the cut
/// @param most  limbs that are looked for
/// @return  nothing if no way is so much shorter than the one before that limbs can be told from the rest
/// @throws model::Error kInterrupted
/// Deterministic. Cost: little more than one search for shortest paths over the component.
[[nodiscard]] std::optional<CutGraph> limb_cut(const TriMesh& component, std::size_t most,
                                               const model::Progress& progress);

/// The component opened along that cut for an m x n grid, where its border has eight samples to a limb: a cut to more
/// starves the longer ones.
/// @throws model::Error kInterrupted; kGridTooSmall if its paths are more than the border has samples for
[[nodiscard]] std::optional<CutSearchResult> open_limbs(const TriMesh& component, std::uint32_t m, std::uint32_t n,
                                                        const model::Progress& progress);

}  // namespace dgm::bake
