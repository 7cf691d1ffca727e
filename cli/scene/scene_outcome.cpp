// SPDX-License-Identifier: GPL-3.0-or-later
// cli/scene/scene_outcome.cpp
#include "scene/scene_outcome.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "baking/option_names.h"
#include "batch/report_text.h"
#include "model/codes.h"

namespace dgm::scene {
namespace {

using bake::bytes_text;
using nlohmann::json;

AssetOutcome outcome_of(const SceneAsset& asset, const bake::AssetResult& result) {
    AssetOutcome out;
    out.name = asset.name;
    if (result.files.empty()) return out;
    out.there = true;
    const bake::SurfaceError& error = result.report.error;
    const bake::ErrorGoal goal = error_goal(asset);
    const auto percent = [&](double length) { return error.diagonal > 0 ? 100 * length / error.diagonal : 0; };
    out.kind = goal.kind;
    out.asked_percent = goal.percent ? goal.value : percent(goal.value);
    out.reached_percent = percent(goal.kind == bake::ErrorKind::kRms ? error.rms : error.hausdorff);
    const bake::OutputFile& file = result.files.front();
    out.file_bytes = file.bytes;
    const Asset baked = open_baked(file.path);
    out.savings = savings(charts_of(baked));
    if (asset.touched) out.tick = measure_tick(baked, asset.footprint, asset.reach);
    return out;
}

/// "stomach 1.2 MB, liver 512.0 kB": the largest assets.
std::string largest_of(const std::vector<AssetOutcome>& assets) {
    constexpr std::size_t kShown = 3;
    std::vector<const AssetOutcome*> order;
    order.reserve(assets.size());
    for (const AssetOutcome& asset : assets) order.push_back(&asset);
    std::stable_sort(order.begin(), order.end(),
                     [](const auto* a, const auto* b) { return a->file_bytes > b->file_bytes; });
    if (order.size() > kShown) order.resize(kShown);
    std::string out;
    for (const AssetOutcome* asset : order)
        out += fmt::format("{}{} {}", out.empty() ? "" : ", ", asset->name, bytes_text(asset->file_bytes));
    return out;
}

}  // namespace

SceneOutcome scene_outcome(const Scene& scene, const bake::BatchPlan& plan,
                           const std::vector<bake::AssetResult>& results) {
    SceneOutcome out;
    for (std::size_t k = 0; k < results.size(); ++k) {
        // A shard has some of the scene's assets.
        const auto asset = std::find_if(scene.assets.begin(), scene.assets.end(),
                                        [&](const SceneAsset& a) { return a.name == plan.assets[k].name; });
        if (asset == scene.assets.end()) continue;
        AssetOutcome one = outcome_of(*asset, results[k]);
        if (one.there) {
            out.bytes += one.file_bytes;
            out.one_size += one.savings.one_size;
        }
        if (one.tick && scene.tick_budget && one.tick->median > *scene.tick_budget)
            out.warnings.push_back(fmt::format(
                "{}: a tick takes {:.1f} us here, more than {:g}; {} samples are in reach: a smaller reach or a larger "
                "tolerance has fewer",
                one.name, 1e6 * one.tick->median, 1e6 * *scene.tick_budget, one.tick->samples));
        out.assets.push_back(std::move(one));
    }
    if (scene.budget && out.bytes > *scene.budget)
        out.over_budget = model::Error(model::codes::kBudgetTooSmall,
                                       fmt::format("the scene takes {} of {}; most of it: {}", bytes_text(out.bytes),
                                                   bytes_text(*scene.budget), largest_of(out.assets)));
    return out;
}

std::string to_text(const Scene& scene, const SceneOutcome& outcome) {
    std::string out;
    for (const AssetOutcome& asset : outcome.assets) {
        if (!asset.there) continue;
        out += fmt::format("  {}: {}, {} error {:.3g} % of {:.3g} %\n", bake::printable(asset.name),
                           bytes_text(asset.file_bytes), bake::name_of(bake::kErrorKindNames, asset.kind),
                           asset.reached_percent, asset.asked_percent);
        std::string steps;
        for (const Saving& step : asset.savings.steps)
            steps +=
                fmt::format("{}{} {} {}", steps.empty() ? "" : "; ", step.choice, step.bytes >= 0 ? "saves" : "costs",
                            bytes_text(static_cast<std::uint64_t>(std::abs(step.bytes))));
        if (!steps.empty()) out += "    " + steps + "\n";
        if (asset.tick)
            out += fmt::format("    tick {:.1f} us (p99 {:.1f}), {} samples in reach of {} steps, state {}\n",
                               1e6 * asset.tick->median, 1e6 * asset.tick->p99, asset.tick->samples, asset.tick->reach,
                               bytes_text(asset.tick->state_bytes));
    }
    out +=
        fmt::format("scene{}{}: {}{}; everything at 257x257 in f32 would take {}{}\n", scene.name.empty() ? "" : " ",
                    bake::printable(scene.name), bytes_text(outcome.bytes),
                    scene.budget ? " of " + bytes_text(*scene.budget) : "", bytes_text(outcome.one_size),
                    outcome.one_size > 0 ? fmt::format(" ({:.1f} % of it)", 100.0 * static_cast<double>(outcome.bytes) /
                                                                                static_cast<double>(outcome.one_size))
                                         : "");
    return out;
}

void add_scene(json& report, const Scene& scene, const SceneOutcome& outcome) {
    json assets = json::array();
    for (const AssetOutcome& asset : outcome.assets) {
        if (!asset.there) continue;
        json one{{"name", asset.name},
                 {"bytes", asset.file_bytes},
                 {"error_kind", bake::name_of(bake::kErrorKindNames, asset.kind)},
                 {"asked_percent", asset.asked_percent},
                 {"reached_percent", asset.reached_percent},
                 {"one_size_bytes", asset.savings.one_size},
                 {"savings", json::array()}};
        for (const Saving& step : asset.savings.steps)
            one["savings"].push_back({{"choice", step.choice}, {"bytes", step.bytes}});
        if (asset.tick)
            one["tick"] = {{"median_seconds", asset.tick->median}, {"p99_seconds", asset.tick->p99},
                           {"ticks", asset.tick->ticks},           {"samples", asset.tick->samples},
                           {"reach", asset.tick->reach},           {"state_bytes", asset.tick->state_bytes}};
        assets.push_back(std::move(one));
    }
    report["scene"] = {{"name", scene.name},
                       {"bytes", outcome.bytes},
                       {"one_size_bytes", outcome.one_size},
                       {"budget_bytes", scene.budget ? json(*scene.budget) : json(nullptr)},
                       {"over_budget", outcome.over_budget.has_value()},
                       {"warnings", outcome.warnings},
                       {"assets", std::move(assets)}};
}

}  // namespace dgm::scene
