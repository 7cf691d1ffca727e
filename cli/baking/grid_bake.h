// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/grid_bake.h
// Bakes a repaired asset on one grid: map -> fit -> layers -> measure, and the result. A search for a size calls these
// for one grid after another.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "baking/bake_options.h"
#include "baking/bake_result.h"
#include "baking/component/cut_memory.h"
#include "baking/stage_log.h"
#include "baking/stages.h"

namespace dgm::bake {

/// Everything that the grids of one asset share.
struct PreparedAsset {
    const BakeOptions& options;
    StageLog& log;
    Repaired source;
    std::vector<double> aspects;       ///< MapRequest::aspects
    std::vector<RingUse> rings;        ///< MapRequest::rings
    std::vector<CutMemory> cuts;       ///< one a component
    std::optional<GridSearch> shapes;  ///< how the aspects were chosen, if a number of samples was asked for
    bool u16 = false;                  ///< positions are stored as u16
};

/// map -> fit
[[nodiscard]] Fitted map_and_fit(PreparedAsset& asset, GridSize largest, CutUse use);
/// map alone
[[nodiscard]] Fitted map_only(PreparedAsset& asset, GridSize largest, CutUse use);

/// Layers of a grid and their measures.
struct MeasuredLayers {
    Layered layered;
    Measured measured;
};

/// layers -> measure, with the layers `names` and so many points.
[[nodiscard]] MeasuredLayers store_and_measure(const PreparedAsset& asset, const Fitted& fitted,
                                               std::span<const std::string> names, std::uint64_t samples);

/// The maps without their report, and the report. `search`: how the grid was found.
[[nodiscard]] BakeResult result_of(const PreparedAsset& asset, MeasuredLayers layers,
                                   const std::optional<GridSearch>& search);

/// layers -> measure with the layers and points of a finished bake. Completes `search` by the error reached, and writes
/// the report into the maps.
[[nodiscard]] BakeResult finish(const PreparedAsset& asset, const Fitted& fitted, std::optional<GridSearch> search);

}  // namespace dgm::bake
