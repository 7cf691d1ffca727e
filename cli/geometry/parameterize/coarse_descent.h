// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/coarse_descent.h
// The long way down of a map's energy, gone on a coarse level.
#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "geometry/parameterize/parameterizer.h"

namespace dgm::bake {

/// Maps a coarse level of its disk, whose border vertices start at its `border_uv`; nothing where it finds none.
using CoarseDescent = std::function<std::optional<std::vector<Vec2d>>(const DiskView&)>;

/// A map of `disk` that `descend` finds on a coarse level with the whole border, with the other vertices put back and
/// relaxed: some sweeps are left for the disk itself. Borders that do not overlap themselves there do not here.
/// @param start  one point per vertex; the coarse border begins where this has it
/// @return  flip-free by the exact predicate; nothing where the disk is not worth a level, or where that fails
/// @throws model::Error kInterrupted
[[nodiscard]] std::optional<std::vector<Vec2d>> map_coarsely(const DiskView& disk, const std::vector<Vec2d>& start,
                                                             const CoarseDescent& descend,
                                                             const model::Progress& progress);

}  // namespace dgm::bake
