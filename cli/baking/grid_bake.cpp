// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/grid_bake.cpp
#include "baking/grid_bake.h"

#include <utility>

#include "baking/up_to_date.h"
#include "dgm/hash.h"
#include "model/layer_names.h"

namespace dgm::bake {
namespace {

/// The geometry is always made, to measure it; it is stored only if it was asked for.
void drop_unasked(std::vector<model::Chart>& charts, std::span<const std::string> names) {
    if (wants(names, model::layers::kGeometry)) return;
    for (model::Chart& chart : charts)
        std::erase_if(chart.layers, [](const model::Layer& l) {
            return l.name == model::layers::kGeometry || l.name == model::layers::kBorderGeometry;
        });
}

Mapped map_grid(PreparedAsset& asset, GridSize largest, CutUse use) {
    return asset.log.run("map", [&](const model::Progress& progress) {
        return map_source(asset.source, {largest, asset.aspects, use, asset.rings}, asset.options, asset.cuts,
                          progress);
    });
}

}  // namespace

Fitted map_and_fit(PreparedAsset& asset, GridSize largest, CutUse use) {
    if (asset.options.fit == Fit::kSample) return map_only(asset, largest, use);
    Mapped mapped = map_grid(asset, largest, use);
    const BakeOptions& options = asset.options;
    const bool searched = options.auto_samples || options.max_error || options.budget_bytes;
    // Finer grids search their own cuts. Those of a dense source take as much room as the source itself.
    if (!searched) asset.cuts = std::vector<CutMemory>(asset.cuts.size());
    return asset.log.run("fit", [&](const model::Progress& progress) {
        Fitted fitted = fit_source(asset.source, std::move(mapped), options, asset.u16, progress);
        if (searched) return fitted;  // a search counts on the sizes that it asks for
        return refine_inverted(asset.source, {largest, asset.aspects, use, asset.rings}, std::move(fitted), options,
                               asset.u16, asset.cuts, progress);
    });
}

Fitted map_only(PreparedAsset& asset, GridSize largest, CutUse use) {
    return {map_grid(asset, largest, use).charts, {}};
}

MeasuredLayers store_and_measure(const PreparedAsset& asset, const Fitted& fitted, std::span<const std::string> names,
                                 std::uint64_t samples) {
    MeasuredLayers out;
    out.layered = asset.log.run("layers", [&](const model::Progress& progress) {
        return store_layers(asset.source, fitted, names, asset.options, asset.u16, progress);
    });
    out.measured = asset.log.run("measure", [&](const model::Progress& progress) {
        return measure_layers(asset.source, fitted, out.layered, samples, progress);
    });
    return out;
}

BakeResult result_of(const PreparedAsset& asset, MeasuredLayers layers, const std::optional<GridSearch>& search) {
    BakeResult out;
    const SourceFacts& facts = asset.source.facts;
    const std::string settings = canonical_settings(asset.options);
    out.maps.generator = generator();
    out.maps.source_name = facts.name;
    out.maps.source_hash = facts.source_hash;
    out.maps.settings_hash = formats::hash_bytes(std::as_bytes(std::span(settings)));
    out.maps.charts = std::move(layers.layered.charts);
    drop_unasked(out.maps.charts, asset.options.layers);
    out.report.source_name = facts.name;
    out.report.inputs_hash = facts.inputs_hash;
    out.report.inputs = facts.inputs;
    out.report.missing_inputs = facts.missing_inputs;
    out.report.source_vertices = facts.vertices;
    out.report.source_faces = facts.faces;
    out.report.error = layers.measured.error;
    out.report.worst_quantisation = layers.layered.worst_quantisation;
    out.report.repairs = facts.repairs;
    out.report.warnings = facts.warnings;
    out.report.remarks = facts.remarks;
    out.report.charts = std::move(layers.measured.charts);
    out.report.search = search;
    out.report.times = asset.log.times();
    return out;
}

BakeResult finish(const PreparedAsset& asset, const Fitted& fitted, std::optional<GridSearch> search) {
    // dgm-validate measures the same points.
    MeasuredLayers layers = store_and_measure(asset, fitted, asset.options.layers, kSurfaceSamples);
    if (search) {
        const SurfaceError& error = layers.measured.error;
        search->reached = search->kind == ErrorKind::kHausdorff ? error.hausdorff : error.rms;
        search->reached_percent = 100 * search->reached / error.diagonal;
    }
    BakeResult out = result_of(asset, std::move(layers), search);
    out.maps.report_json = to_json(out.report, false);
    return out;
}

}  // namespace dgm::bake
