// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/scene_plan.cpp
#include "scene/scene_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "baking/materials.h"
#include "baking/option_names.h"
#include "batch/report_text.h"
#include "math/portable.h"
#include "model/codes.h"
#include "model/layer_names.h"

namespace dgm::scene {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;

/// Source units that a pixel covers at the asset's nearest distance.
double pixel_length(const SceneAsset& asset) {
    const double half_angle = asset.view.fov_degrees / 2 * std::numbers::pi / 180;
    return 2 * *asset.distance * math::tan(half_angle) / asset.view.rows;
}

std::string size_text(std::uint64_t rows, std::uint64_t cols) {
    return fmt::format("{}x{}", rows, cols);
}

/// Bytes of a chart's layers, docs/design.md section 4.
struct ChartBytes {
    std::uint64_t geometry = 0, texture = 0, tables = 0;
    std::map<std::string, std::uint64_t> others;  ///< by the name that --layers takes
};

std::uint64_t pyramid_bytes(std::uint64_t rows, std::uint64_t cols) {
    const auto half = [](std::uint64_t n, std::uint64_t by) { return (n + by - 1) / by; };
    std::uint64_t nodes = 0, r = half(rows - 1, 8), c = half(cols - 1, 8);
    for (;; r = half(r, 2), c = half(c, 2)) {
        nodes += r * c;
        if (r * c == 1) return nodes * 6 * sizeof(float);
    }
}

/// A chart of the baseline: every layer, f32, texture two pixels a grid step.
ChartBytes one_size_bytes(std::uint64_t rows, std::uint64_t cols, std::uint64_t position_bytes) {
    const std::uint64_t samples = rows * cols, fine = (2 * rows - 1) * (2 * cols - 1);
    ChartBytes out;
    out.geometry = samples * position_bytes;
    out.texture = fine * 4;
    out.tables = (rows - 1) * (cols - 1);  // diagonals; seams and masks are the same few samples in all bakes
    out.others = {{model::layers::kNormal, samples * 4},
                  {model::layers::kBump, fine * 2},
                  {model::layers::kCollision, pyramid_bytes(rows, cols) + samples * 4},
                  {model::layers::kDeformation, samples * 16},
                  {model::layers::kContact, samples * 8}};
    return out;
}

std::uint64_t sum(const ChartBytes& chart) {
    std::uint64_t out = chart.geometry + chart.texture + chart.tables;
    for (const auto& [name, bytes] : chart.others) out += bytes;
    return out;
}

}  // namespace

bake::ErrorGoal error_goal(const SceneAsset& asset) {
    const Tolerance& tolerance = asset.tolerance;
    switch (tolerance.unit) {
        case ToleranceUnit::kPercent:
            return {tolerance.value, true, tolerance.kind};
        case ToleranceUnit::kSource:
            return {tolerance.value, false, tolerance.kind};
        case ToleranceUnit::kPixels:
            break;
    }
    return {tolerance.value * pixel_length(asset), false, tolerance.kind};
}

std::vector<std::string> needed_layers(const SceneAsset& asset) {
    std::vector<std::string> out;
    for (const std::string_view name : bake::kLayerNames) {
        const bool named = std::find(asset.layers.begin(), asset.layers.end(), name) != asset.layers.end();
        const bool wished =
            name == model::layers::kGeometry || (name == model::layers::kNormal && asset.lit) ||
            (name == model::layers::kTexture && asset.textured) || (name == model::layers::kBump && asset.detail) ||
            ((name == model::layers::kCollision || name == model::layers::kDeformation) && asset.touched) ||
            (name == model::layers::kContact && (asset.touched || asset.contact));
        if (asset.layers.empty() ? wished : named) out.emplace_back(name);
    }
    return out;
}

bake::BakeOptions bake_options(const SceneAsset& asset) {
    bake::BakeOptions out;
    out.size = asset.largest;
    out.max_error = error_goal(asset);
    out.budget_bytes = asset.budget;
    out.method = asset.method;
    out.domain = asset.domain;
    out.fit = asset.fit;
    out.precision = asset.precision.value_or(bake::Precision::kAuto);
    out.layers = needed_layers(asset);
    out.texture = asset.fabric;
    out.texture_bytes = asset.texture_budget;
    if (asset.distance) out.texel_length = pixel_length(asset);
    out.metres_per_unit = asset.metres_per_unit;
    out.material = asset.material;
    out.material_file = asset.material_file;
    return out;
}

bake::BatchPlan plan_batch(const Scene& scene, const fs::path& folder) {
    bake::BatchPlan out;
    out.folder = folder;
    std::set<fs::path> sources;
    std::error_code error;
    for (const SceneAsset& asset : scene.assets) sources.insert(fs::weakly_canonical(asset.source, error));
    for (const SceneAsset& asset : scene.assets) {
        bake::PlannedAsset job;
        job.source = asset.source;
        job.dgm = folder / (asset.name + ".dgm");
        job.name = asset.name;
        job.options = bake_options(asset);
        if (!fs::is_regular_file(asset.source, error))
            job.refusal = model::Error(codes::kFileMissing,
                                       fmt::format("there is no such file (asset {}, line {} of "
                                                   "the scene)",
                                                   asset.name, asset.line),
                                       asset.source.string());
        if (sources.contains(fs::weakly_canonical(job.dgm, error)))
            throw model::Error(codes::kUsage, "the output would overwrite a source of the scene", job.dgm.string());
        out.assets.push_back(std::move(job));
    }
    return out;
}

std::vector<std::string> describe(const SceneAsset& asset) {
    const bake::ErrorGoal goal = error_goal(asset);
    const std::string kind(bake::name_of(bake::kErrorKindNames, goal.kind));
    std::vector<std::string> out;
    out.push_back(
        asset.tolerance.unit == ToleranceUnit::kPixels
            ? fmt::format("tolerance {:g} px at distance {:g} ({} rows over {:g} degrees): {:.3g} units {}",
                          asset.tolerance.value, *asset.distance, asset.view.rows, asset.view.fov_degrees, goal.value,
                          kind)
            : fmt::format("tolerance {:.3g}{} {}", goal.value, goal.percent ? " % of the diagonal" : " units", kind));
    const std::vector<std::string> layers = needed_layers(asset);
    std::string why = "as named";
    if (asset.layers.empty())
        why = fmt::format("{}, {}, {}, {}", asset.touched ? "touched" : "not touched",
                          asset.touched || asset.contact ? "contact" : "no contact", asset.lit ? "lit" : "not lit",
                          asset.textured ? "textured" : "no texture");
    out.push_back(fmt::format("layers {} ({})", fmt::join(layers, ", "), why));
    const std::string precision = asset.precision ? std::string(bake::name_of(bake::kPrecisionNames, *asset.precision))
                                                  : "as the tolerance allows";
    out.push_back(
        fmt::format("grid at most {}, precision {}", size_text(asset.largest.rows, asset.largest.cols), precision));
    if (asset.metres_per_unit) {
        std::string text = fmt::format("a unit is {:g} m", *asset.metres_per_unit);
        for (const bake::MaterialKey& key : bake::kMaterialKeys)
            if (asset.material) text += fmt::format(", {} {:g}", key.name, *asset.material.*key.field);
        out.push_back(text);
    }
    if (asset.texture_budget) out.push_back(fmt::format("texture at most {} bytes", *asset.texture_budget));
    if (asset.touched)
        out.push_back(fmt::format("touched with a {} footprint of {:g}{} radius",
                                  bake::name_of(kFootprintNames, asset.footprint), asset.reach.value,
                                  asset.reach.percent ? " % of the diagonal" : " units"));
    return out;
}

std::string plan_text(const Scene& scene) {
    std::string out;
    for (const SceneAsset& asset : scene.assets) {
        out += fmt::format("{} <- {}\n", bake::printable(asset.name), bake::printable(asset.source.string()));
        for (const std::string& line : describe(asset)) out += "  " + line + "\n";
    }
    return out;
}

const BakedLayer* BakedChart::find(std::string_view name) const {
    const auto found = std::find_if(layers.begin(), layers.end(), [&](const BakedLayer& l) { return l.name == name; });
    return found == layers.end() ? nullptr : &*found;
}

Savings savings(const std::vector<BakedChart>& charts) {
    constexpr std::uint64_t kOneSize = 257, kF32 = 12, kU16 = 6;
    Savings out;
    std::uint64_t largest = 1;
    for (const BakedChart& chart : charts) largest = std::max<std::uint64_t>({largest, chart.rows, chart.cols});
    const double grow =
        static_cast<double>(kOneSize - 1) / static_cast<double>(std::max<std::uint64_t>(1, largest - 1));
    const auto scaled = [&](std::uint32_t side) {
        return std::max<std::uint64_t>(3, 1 + static_cast<std::uint64_t>(std::lround((side - 1) * grow)));
    };
    std::uint64_t at_grid = 0, at_precision = 0, at_layers = 0;
    std::set<std::string> dropped;
    std::string grid, texture;
    bool u16 = false;
    for (const BakedChart& chart : charts) {
        out.one_size += sum(one_size_bytes(scaled(chart.rows), scaled(chart.cols), kF32));
        at_grid += sum(one_size_bytes(chart.rows, chart.cols, kF32));
        const BakedLayer* geometry = chart.find(model::layers::kGeometry);
        const bool half = geometry != nullptr && geometry->type == layout::ElementType::kU16;
        u16 = u16 || half;
        ChartBytes bytes = one_size_bytes(chart.rows, chart.cols, half ? kU16 : kF32);
        at_precision += sum(bytes);
        for (auto& [name, size] : bytes.others)
            if (chart.find(name) == nullptr) {
                dropped.insert(name);
                size = 0;
            }
        const BakedLayer* picture = chart.find(model::layers::kTexture);
        if (picture == nullptr) {
            dropped.insert(model::layers::kTexture);
            bytes.texture = 0;
        }
        at_layers += sum(bytes);
        if (chart.rows == largest || chart.cols == largest) {
            grid = size_text(chart.rows, chart.cols);
            if (picture != nullptr && picture->shape.size() >= 2)
                texture = size_text(picture->shape[0], picture->shape[1]);
        }
        for (const BakedLayer& layer : chart.layers) out.bytes += layer.bytes;
    }
    const auto step = [&](const std::string& choice, std::uint64_t before, std::uint64_t after) {
        const auto saved = static_cast<std::int64_t>(before) - static_cast<std::int64_t>(after);
        if (saved != 0) out.steps.push_back({choice, saved});
    };
    step("grid " + grid, out.one_size, at_grid);
    step(u16 ? "precision u16" : "precision", at_grid, at_precision);
    step(fmt::format("without {}", fmt::join(dropped, ", ")), at_precision, at_layers);
    step(texture.empty() ? "seams and tables" : "texture " + texture, at_layers, out.bytes);
    return out;
}

}  // namespace dgm::scene
