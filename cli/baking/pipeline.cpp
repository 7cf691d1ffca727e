// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/pipeline.cpp
#include "baking/pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "baking/bake_mesh.h"
#include "baking/component/component_shapes.h"
#include "baking/grid_bake.h"
#include "baking/notices.h"
#include "baking/search/goal_bake.h"
#include "baking/search/size_search.h"
#include "baking/stage_log.h"
#include "baking/stages.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

/// --size auto:N: chooses the aspects of the components. @return the grid of the largest
GridSize choose_shapes(PreparedAsset& asset) {
    const std::uint64_t samples = *asset.options.auto_samples;
    ComponentShapes chosen = asset.log.run("shape", [&](const model::Progress& progress) {
        return choose_component_shapes(asset.source.components, asset.source.areas, samples, asset.options, asset.cuts,
                                       part_of(progress, "shape", 0, 1));
    });
    asset.aspects = std::move(chosen.aspects);
    asset.rings = std::move(chosen.rings);
    const GridSize out = grid_of(samples, asset.aspects[asset.source.largest]);
    GridSearch& search = asset.shapes.emplace();
    search.goal = SearchGoal::kSamples;
    search.asked_samples = samples;
    search.shapes = std::move(chosen.trials);
    for (GridTrial& trial : search.shapes) trial.rms *= asset.source.frame.diagonal;
    search.rows = out.rows;
    search.cols = out.cols;
    return out;
}

/// No --size: rings and long surfaces get the shapes that suit them. @return the grid of the largest component
GridSize shape_unasked(PreparedAsset& asset) {
    const GridSize named = asset.options.size;
    const std::uint64_t samples = std::uint64_t{named.rows} * named.cols;
    ComponentShapes chosen = asset.log.run("shape", [&](const model::Progress& progress) {
        return choose_unasked_shapes(asset.source.components, asset.source.areas, samples, asset.options, asset.cuts,
                                     part_of(progress, "shape", 0, 1));
    });
    asset.aspects = std::move(chosen.aspects);
    asset.rings = std::move(chosen.rings);
    const double aspect = asset.aspects[asset.source.largest];
    return aspect == 1 ? named : even_grid_of(samples, aspect);
}

/// Tells what is known of the mesh before the long part begins.
void tell_notices(const Repaired& source, const BakeOptions& options) {
    if (options.on_notice)
        for (const Notice& notice : notices(source)) options.on_notice(notice);
}

/// Physics refuses a chart that is smaller than the length over which its material bends.
void check_material(const Repaired& source, const BakeOptions& options) {
    if (!options.material || !options.metres_per_unit) return;
    const double length = std::sqrt(double{options.material->bending} / double{options.material->membrane});
    const double body = source.frame.diagonal * *options.metres_per_unit;
    if (length > body)
        throw model::Error(model::codes::kBodyTooSmall,
                           fmt::format("the material bends over {:.3g} m, (bending / membrane)^(1/2), but the body's "
                                       "bounding-box diagonal is {:.3g} m",
                                       length, body));
}

/// The stages after the import. `images` replace the files that the materials name.
BakeResult bake_imported(Imported imported, std::optional<MaterialImages> images, const BakeOptions& options,
                         StageLog& log) {
    Repaired source = log.run("repair", [&](const auto&) { return repair_source(std::move(imported)); });
    check_material(source, options);
    source.images = log.run("textures", [&](const auto&) {
        return images ? std::move(*images) : load_images(source.materials, options.texture, source.facts.warnings);
    });
    tell_notices(source, options);
    const std::size_t components = source.components.size();
    const bool u16 = stores_u16(options, source.frame.diagonal);
    PreparedAsset asset{.options = options,
                        .log = log,
                        .source = std::move(source),
                        .aspects = std::vector<double>(components),
                        .rings = {},
                        .cuts = std::vector<CutMemory>(components),
                        .shapes = std::nullopt,
                        .u16 = u16};
    const GridSize largest = options.auto_samples ? choose_shapes(asset)
                             : options.any_aspect ? shape_unasked(asset)
                                                  : options.size;
    if (options.max_error) return bake_to_error(asset, largest);
    if (options.budget_bytes) return bake_to_budget(asset, largest);
    return finish(asset, map_and_fit(asset, largest, CutUse::kSearch), asset.shapes);
}

}  // namespace

BakeResult bake_asset(const std::filesystem::path& source, const BakeOptions& options,
                      const model::Progress& progress) {
    StageLog log(progress);
    Imported imported = log.run("import", [&](const auto&) { return import_file(source, options.asset_roots); });
    return bake_imported(std::move(imported), std::nullopt, options, log);
}

BakeResult bake_mesh(MeshInMemory source, const BakeOptions& options, const model::Progress& progress) {
    StageLog log(progress);
    Imported imported =
        log.run("import", [&](const auto&) { return import_mesh(std::move(source.mesh), std::move(source.name)); });
    return bake_imported(std::move(imported), std::move(source.images), options, log);
}

}  // namespace dgm::bake
