// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/batch_report_json.cpp
#include "batch/batch_report_json.h"

#include <algorithm>

#include "baking/option_names.h"
#include "batch/repeat_command.h"
#include "batch/report_text.h"
#include "worker/material_json.h"

namespace dgm::bake {
namespace {

using nlohmann::json;

json size_json(const GridSize& size) {
    return {{"rows", size.rows}, {"cols", size.cols}};
}

json settings_json(const BakeOptions& options) {
    json out{{"size",
              options.auto_samples ? json("auto:" + std::to_string(*options.auto_samples)) : size_json(options.size)},
             {"method", name_of(options.method)},
             {"domain", name_of(kDomainNames, options.domain)},
             {"fit", name_of(kFitNames, options.fit)},
             {"precision", name_of(kPrecisionNames, options.precision)},
             {"layers", options.layers.empty() ? json("all") : json(options.layers)},
             {"texture", options.texture.empty() ? json(nullptr) : json(options.texture.string())},
             {"texture_size", options.texture_size ? size_json(*options.texture_size) : json("grid")},
             {"format", json::array()},
             {"exr_layout", name_of(kExrLayoutNames, options.exr_layout)}};
    if (options.bump_size) out["bump_size"] = size_json(*options.bump_size);
    if (options.texture_bytes) out["texture_bytes"] = *options.texture_bytes;
    if (options.texel_length) out["texel_length"] = *options.texel_length;
    if (options.metres_per_unit) out["metres_per_unit"] = *options.metres_per_unit;
    if (options.material) out["material"] = material_json(*options.material);
    if (!options.ablate.empty()) out["ablate"] = options.ablate;
    if (options.max_error)
        out["max_error"] = {{options.max_error->percent ? "percent" : "source_units", options.max_error->value},
                            {"kind", name_of(kErrorKindNames, options.max_error->kind)}};
    if (options.budget_bytes) out["budget_bytes"] = *options.budget_bytes;
    if (options.write_dgm) out["format"].push_back("dgm");
    if (options.write_exr) out["format"].push_back("exr");
    return out;
}

json error_json(const model::Error& error, const std::string& worker_output) {
    json out{{"code", error.code().id()},
             {"name", error.code().name},
             {"message", error.what()},
             {"place", error.place()},
             {"stage", error.stage()},
             {"hint", error.hint()},
             {"exit_code", static_cast<int>(error.code().exit)}};
    if (!worker_output.empty()) out["worker_output"] = worker_output;
    return out;
}

std::string shown(const std::filesystem::path& path) {
    return path.lexically_normal().string();
}

}  // namespace

json asset_json(const PlannedAsset& asset, const AssetResult& result) {
    json out{{"source", asset.source.string()},          {"name", asset.name},
             {"outcome", name_of(result.outcome)},       {"seconds", result.seconds},
             {"settings", settings_json(asset.options)}, {"command", repeat_command(asset)}};
    out["outputs"] = json::array();
    for (const std::filesystem::path& output : outputs_of(asset)) out["outputs"].push_back(shown(output));
    for (const std::filesystem::path& output : asset.exports)
        out["settings"]["format"].push_back(output.extension().string().substr(1));
    out["files"] = json::array();
    for (const OutputFile& file : result.files)
        out["files"].push_back({{"path", shown(file.path)}, {"bytes", file.bytes}});
    if (result.outcome == Outcome::kBaked) out["report"] = json::parse(to_json(result.report, true));
    if (result.outcome == Outcome::kUpToDate) out["report"] = json::parse(to_json(result.report, false));
    if (result.error) out["error"] = error_json(*result.error, result.worker_output);
    return out;
}

void add_other_files(json& report, const std::vector<LeftOutFile>& left_out, const std::vector<LeftOver>& left_over) {
    for (const LeftOutFile& file : left_out)
        report["left_out"].push_back({{"path", file.path.string()}, {"why", file.why}});
    for (const LeftOver& file : left_over)
        report["left_over"].push_back(
            {{"path", shown(file.path)},
             {"source_name", file.source_name},
             {"replacement", file.replacement.empty() ? json(nullptr) : json(shown(file.replacement))},
             {"removed", file.removed}});
}

json report_frame(std::string_view generator, model::ExitCode exit) {
    return {{"generator", generator},
            {"report_version", kReportVersion},
            {"exit_code", static_cast<int>(exit)},
            {"summary", json::object()}};
}

void set_count(json& report, Outcome outcome, std::uint64_t count) {
    std::string key(name_of(outcome));
    std::replace(key.begin(), key.end(), ' ', '_');
    report["summary"][key] = count;
}

std::string batch_report_json(const BatchPlan& plan, const BatchOptions& batch, const std::vector<AssetResult>& results,
                              std::string_view generator) {
    json out = report_frame(generator, worst_exit(results));
    out["run"] = {{"time_limit_seconds", batch.time_limit_seconds},
                  {"memory_limit_bytes", batch.memory_bytes},
                  {"jobs", batch.jobs}};
    out["summary"] = {{"assets", results.size()}};
    for (const Outcome outcome : kOutcomes) {
        const auto count = std::count_if(results.begin(), results.end(),
                                         [&](const AssetResult& result) { return result.outcome == outcome; });
        set_count(out, outcome, static_cast<std::uint64_t>(count));
    }
    out["assets"] = json::array();
    for (std::size_t k = 0; k < results.size(); ++k) out["assets"].push_back(asset_json(plan.assets[k], results[k]));
    return out.dump(2, ' ', false, json::error_handler_t::replace) + '\n';
}

}  // namespace dgm::bake
