// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/pipeline.h
// The stages of a bake, in order (design section 2), for one asset, in this process.
#pragma once
#include <filesystem>

#include "baking/bake_options.h"
#include "baking/bake_report.h"
#include "model/map_set.h"
#include "model/progress.h"

namespace dgm::bake {

struct BakeResult {
    model::MapSet maps;
    BakeReport report;
};

/// import -> repair -> cut -> parameterize -> resample -> fit -> layers -> measure. Writes nothing.
/// Deterministic: the same input and options give the same `maps`, whatever the thread count, path or locale.
/// @throws model::Error with the stage's name; kInterrupted if progress says so
[[nodiscard]] BakeResult bake_asset(const std::filesystem::path& source, const BakeOptions& options,
                                    const model::Progress& progress);

}  // namespace dgm::bake
