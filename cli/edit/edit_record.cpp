// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/edit_record.cpp
#include "edit/edit_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <variant>
#include <vector>

#include "dgm/hash.h"
#include "files/nesting.h"
#include "model/codes.h"
#include "model/layer_names.h"
#include "process/json_apart.h"
#include "validate/validation.h"

namespace dgm::edit {
namespace {

using Json = nlohmann::json;

bool has_new_attributes(const PaintedMap& map, const PartEdit& edit) {
    return map.original().charts[edit.chart].layers[edit.layer].attributes !=
           map.maps().charts[edit.chart].layers[edit.layer].attributes;
}

bool is_recorded(const PaintedMap& map, const PartEdit& edit) {
    return edit.part.is_editable && (!edit.is_empty() || has_new_attributes(map, edit));
}

/// "normal_rms_bump_degrees" was measured with the heights of the bake.
void take_back(Json& report) {
    constexpr const char* kClaim = "normal_rms_bump_degrees";
    const auto clear = [&](Json& of) {
        const auto error = of.find("error");
        if (error != of.end() && error->is_object() && error->contains(kClaim)) (*error)[kClaim] = nullptr;
    };
    clear(report);
    if (const auto charts = report.find("charts"); charts != report.end() && charts->is_array())
        for (Json& chart : *charts)
            if (chart.is_object()) clear(chart);
}

std::string plural(std::uint64_t count, const char* what) {
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

/// One for all: shares of a shader of several charts differ little, and the least says most.
std::string shading_note(const PaintedMap& map, const PartEdit& edit) {
    if (edit.part.layer != model::layers::kBump || edit.is_empty()) return {};
    const auto& attributes = map.maps().charts[edit.chart].layers[edit.layer].attributes;
    const auto found = attributes.find("shading");
    const auto* weight = found == attributes.end() ? nullptr : std::get_if<std::vector<double>>(&found->second);
    return fmt::format("; a shader takes {:.0f} % of it (attribute shading)",
                       weight == nullptr || weight->empty() ? 0.0 : 100 * weight->front());
}

}  // namespace

void record_edits(PaintedMap& map) {
    if (formats::too_deep_json(map.maps().report_json, formats::kMostNesting))  // it could not be written again
        throw model::Error(model::codes::kBadReport, "the report is nested too deeply", "/report");
    Json report = bake::read_map_report(map.maps().report_json);
    if (!report.is_object()) return;
    std::vector<Json> rows;
    for (const PartEdit* edit : map.edits()) {
        if (!is_recorded(map, *edit)) continue;
        if (edit->part.layer == model::layers::kBump) take_back(report);
        const std::string source = edit->source.filename().string();
        const auto same = [&](const Json& row) { return row["layer"] == edit->part.name && row["source"] == source; };
        if (const auto row = std::find_if(rows.begin(), rows.end(), same); row != rows.end())  // of another chart
            (*row)["samples"] = (*row)["samples"].get<std::uint64_t>() + edit->samples;
        else
            rows.push_back({{"layer", edit->part.name},
                            {"samples", edit->samples},
                            {"source", source},
                            {"source_hash", formats::to_hex(formats::hash_file(edit->source))}});
    }
    if (rows.empty()) return;
    Json& edits = report["edits"];
    if (!edits.is_array()) edits = Json::array();
    for (Json& row : rows) edits.push_back(std::move(row));
    map.maps().report_json = report.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string edit_lines(const PaintedMap& map) {
    std::string out;
    const bool several = map.original().charts.size() > 1;
    for (const PartEdit* edit : map.edits()) {
        if (!edit->part.is_editable) continue;
        const bool is_picture = edit->part.layer == model::layers::kTexture || edit->part.layer == model::layers::kBump;
        const char* sample = is_picture ? "texel" : "sample";
        out += fmt::format("  {}{:<12} ", several ? fmt::format("chart {}: ", edit->chart) : "", edit->part.name);
        if (edit->is_trusted)
            out += fmt::format("taken as it is, {}", plural(edit->changed.size(), sample));
        else if (edit->samples == 0)
            out += has_new_attributes(map, *edit) ? "attributes changed" : "unchanged";
        else
            out += fmt::format("{} of {} changed, by at most {:.4g}", edit->samples,
                               plural(edit->changed.size(), sample), edit->largest);
        const auto add = [&](std::uint64_t count, const char* what, const char* done) {
            if (count > 0) out += fmt::format("; {} {}", plural(count, what), done);
        };
        add(edit->joined, is_picture ? "seam texel" : "seam sample", "joined");
        add(edit->clamped, "number", "clamped to 0..1");
        add(edit->outside, "sample", "off the surface left alone");
        add(edit->padded, "texel", "beyond the surface coloured alike");
        out += shading_note(map, *edit) + "\n";
    }
    return out;
}

void check_result(const PaintedMap& map) {
    const auto errors = [](const model::MapSet& maps) {
        std::vector<formats::Finding> found = validate::validate_maps(maps).findings;
        std::erase_if(found, [](const formats::Finding& f) { return f.severity != formats::Severity::kError; });
        return found;
    };
    const std::vector<formats::Finding> now = errors(map.maps());
    if (now.empty()) return;
    const std::vector<formats::Finding> before = errors(map.original());
    const std::vector<const PartEdit*> edits = map.edits();
    const bool is_trusted = std::any_of(edits.begin(), edits.end(), [](const PartEdit* e) { return e->is_trusted; });
    for (const formats::Finding& f : now) {
        const bool is_old = !is_trusted && std::any_of(before.begin(), before.end(), [&](const formats::Finding& old) {
            return old.code == f.code && old.place == f.place;
        });
        if (!is_old) throw model::Error(*f.code, f.message, f.place);
    }
}

}  // namespace dgm::edit
