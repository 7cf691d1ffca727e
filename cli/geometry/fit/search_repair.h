// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/search_repair.h
// Repairs inverted faces by trying one or two samples at many places, judged by the measure itself.
#pragma once
#include <cstddef>
#include <span>

#include "geometry/fit/matches.h"

namespace dgm::bake {

struct SearchEffort {
    std::size_t tries = 40'000;       ///< at most, less by those that were made: some tenths of a second
    std::size_t most_a_face = 3'000;  ///< of these in one annealing, which has as many in any case
    double unit = 1;  ///< distance from the source that costs a share of an inverted face, a spacing at most
    double lift = 0;  ///< spacings of the grid by which samples may leave the source, to the side of their faces
};

/// Where `repair_by_vertex` makes no progress, because no single sample's step helps or because a walk along the source
/// ends on the wrong sheet: samples of each inverted face and of the faces around it, alone and by twos, are tried at
/// many places around them on the source, and stay where the measure (metrics/turned_faces.h) finds fewer faults, no
/// source vertex is uncovered and no face leaves the source. Classes marked `fixed` stay. `matches` is kept up to date.
/// Bounded work; deterministic.
/// @param index  of the source
/// @return  true if a sample moved
bool repair_by_search(const LinkedSurface& source, const ClosestPointIndex& index, WeldedGrid& grid, Matches& matches,
                      std::span<const char> fixed, std::span<const std::uint32_t> inverted, SearchEffort& effort);

}  // namespace dgm::bake
