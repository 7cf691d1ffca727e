// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/scene_outcome.h
// Outcome of a scene's bake: bytes against one size for all, ticks against the budget.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "batch/batch_plan.h"
#include "batch/batch_runner.h"
#include "model/error.h"
#include "scene/scene_file.h"
#include "scene/scene_plan.h"
#include "scene/tick_time.h"

namespace dgm::scene {

struct AssetOutcome {
    std::string name;
    bool there = false;  ///< the file was baked or is up to date; else nothing below is filled in
    std::uint64_t file_bytes = 0;
    double asked_percent = 0, reached_percent = 0;  ///< error, % of the diagonal
    bake::ErrorKind kind = bake::ErrorKind::kRms;
    Savings savings;
    std::optional<TickTime> tick;  ///< touched assets
};

struct SceneOutcome {
    std::vector<AssetOutcome> assets;
    std::uint64_t bytes = 0, one_size = 0;    ///< sums over assets that are there
    std::optional<model::Error> over_budget;  ///< the files together are larger than the scene's budget
    std::vector<std::string> warnings;        ///< ticks over their budget
};

/// Reads the baked files back, and times ticks.
/// @param results  one for each asset of the scene, in its order
/// @throws model::Error if an output cannot be read any more
[[nodiscard]] SceneOutcome scene_outcome(const Scene& scene, const bake::BatchPlan& plan,
                                         const std::vector<bake::AssetResult>& results);

/// A few lines for people, with a line end each.
[[nodiscard]] std::string to_text(const Scene& scene, const SceneOutcome& outcome);

/// Puts the outcome into a batch report as its key "scene".
void add_scene(nlohmann::json& batch_report, const Scene& scene, const SceneOutcome& outcome);

}  // namespace dgm::scene
