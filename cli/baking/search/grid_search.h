// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/search/grid_search.h
// Searches by error and by file size: size_search.h with words, margins and the report around it.
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "baking/attempt.h"
#include "baking/bake_options.h"
#include "baking/bake_report.h"

namespace dgm::bake {

/// How the search has grids baked. Both are called in turn, on the caller's thread.
struct GridTries {
    /// Bakes one grid and measures the quantity of the search: rms and hausdorff in source units, or bytes. The
    /// failures kGridTooSmall and kMapInvalid count against the grid; others end the search.
    std::function<Attempt<GridTrial>(GridSize)> measure;
    /// The grid measured last is the best answer so far.
    std::function<void(GridSize)> keep;
};

/// The share of the measured error that the answer stays below what was asked: other random points on the same surfaces
/// give an rms within 1 % and a maximum within 5 % (dgm-validate allows the same).
[[nodiscard]] double error_margin(ErrorKind kind);

/// --max-error: the smallest grid of `ladder` that holds `goal`. `diagonal` in source units; `first_side`: samples
/// along the side of the square grid to begin with. rows and cols of the result are those of the grid kept last.
/// @throws model::Error kErrorNotReached with how far it got; the error of `measure` if no grid has a valid map
[[nodiscard]] GridSearch search_by_error(const ErrorGoal& goal, double diagonal, const std::vector<GridSize>& ladder,
                                         double first_side, const GridTries& tries);

/// --budget: the largest grid of `ladder` whose file has at most `budget` bytes.
/// @throws model::Error kBudgetTooSmall; the error of `measure` if no grid has a valid map
[[nodiscard]] GridSearch search_by_budget(std::uint64_t budget, const std::vector<GridSize>& ladder,
                                          const GridTries& tries);

}  // namespace dgm::bake
