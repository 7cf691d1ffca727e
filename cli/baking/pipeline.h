// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/pipeline.h
// Bakes one mesh file in this process: runs the stages (stages.h) in order.
#pragma once
#include <filesystem>

#include "baking/bake_options.h"
#include "baking/bake_result.h"
#include "model/progress.h"

namespace dgm::bake {

/// import -> repair -> textures -> [shape] -> map -> fit -> layers -> measure. Writes nothing. bake_mesh.h does the
/// same for a mesh in memory. Deterministic: the same input and options give the same `maps`, whatever the thread
/// count, path or locale.
/// @throws model::Error with the stage's name; kInterrupted if progress says so
[[nodiscard]] BakeResult bake_asset(const std::filesystem::path& source, const BakeOptions& options,
                                    const model::Progress& progress);

}  // namespace dgm::bake
