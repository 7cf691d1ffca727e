// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/component_bake.h
// Makes one component a sampled chart: decides which candidates are tried, and keeps the best.
#pragma once
#include "baking/attempt.h"
#include "baking/bake_options.h"
#include "baking/component/candidates.h"
#include "baking/component/cut_memory.h"
#include "model/progress.h"

namespace dgm::bake {

/// Whether a ring is unrolled, its loops on opposite sides of the square.
enum class RingUse {
    kTried,  ///< beside other charts
    kOnly,   ///< and nothing else is tried; other components have no chart then
    kNot,
};

struct ComponentTask {
    const model::TriMesh& component;
    GridSize size;  ///< tried first
    GridSize most;  ///< the grid grows up to this where the cut does not fit it
    CutUse use = CutUse::kSearch;
    RingUse rings = RingUse::kTried;
    Trials trials = {};
    bool is_one_of_many = false;  ///< of its asset's components: its cut on a small grid is searched once
};

/// `auto` tries the methods that fit the component and keeps the one with the least measured error; a named method is
/// tried alone. `cuts` remembers the cuts found for the same component; task.use says whether they may be used again.
/// @return the error of the last candidate if none has a chart
/// @throws model::Error kInterrupted
[[nodiscard]] Attempt<ComponentResult> bake_component(const ComponentTask& task, const BakeOptions& options,
                                                      CutMemory& cuts, const model::Progress& progress);

}  // namespace dgm::bake
