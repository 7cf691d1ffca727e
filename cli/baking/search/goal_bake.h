// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/search/goal_bake.h
// Bakes the grid that an error or a file size asks for: a search (grid_search.h) over the functions of grid_bake.h.
#pragma once
#include "baking/bake_options.h"
#include "baking/bake_result.h"
#include "baking/grid_bake.h"

namespace dgm::bake {

/// --max-error, with or without --budget: the smallest grid up to `most` that holds the error.
/// @throws model::Error kErrorNotReached; kBudgetTooSmall if its file is larger than the budget
[[nodiscard]] BakeResult bake_to_error(PreparedAsset& asset, GridSize most);

/// --budget: the largest grid up to `most` whose .dgm fits.
/// @throws model::Error kBudgetTooSmall
[[nodiscard]] BakeResult bake_to_budget(PreparedAsset& asset, GridSize most);

/// True if positions are to be stored as u16. Precision::kAuto takes u16 where rounding costs little of the error asked
/// for: rounding to 65536 steps over the longest side of the bounding box moves a point by a twelfth root of a step
/// squared rms along any direction.
[[nodiscard]] bool stores_u16(const BakeOptions& options, double diagonal);

}  // namespace dgm::bake
