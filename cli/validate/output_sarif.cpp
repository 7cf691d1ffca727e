// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/output_sarif.cpp
// [SARIF] Static Analysis Results Interchange Format 2.1.0, OASIS standard.
#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "dgm/hash.h"
#include "model/codes.h"
#include "validate/code_pages.h"
#include "validate/output.h"

namespace dgm::validate {
namespace {
using formats::Finding;
using nlohmann::ordered_json;

/// A path as the reference of a URI: all characters in percent but unreserved ones and slashes.
std::string uri_of(const std::filesystem::path& path) {
    std::string out = path.is_absolute() ? "file://" : "";
    for (const char c : path.lexically_normal().generic_string()) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
                           c == '.' || c == '_' || c == '~' || c == '/';
        out += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
    return out;
}

std::size_t rule_index(const model::Code& code) {
    std::size_t index = 0;
    while (model::codes::kAll[index] != &code) ++index;
    return index;
}

ordered_json rules_json() {
    ordered_json rules = ordered_json::array();
    for (const model::Code* code : model::codes::kAll)
        rules.push_back({{"id", code->id()},
                         {"name", code->name},
                         {"shortDescription", {{"text", code->title}}},
                         {"fullDescription", {{"text", fmt::format("{}: {}", code->title, code->why)}}},
                         {"help", {{"text", code->hint}}},
                         {"properties", {{"subject", subject_of(*code)}}}});
    return rules;
}

/// A place of the form FILE:LINE or FILE:LINE:COLUMN, as mesh readers give it.
struct LinePlace {
    std::string file;
    std::vector<int> numbers;  // line, then perhaps column
};
LinePlace line_place(std::string_view place) {
    LinePlace out;
    while (out.numbers.size() < 2) {
        const std::size_t colon = place.rfind(':');
        if (colon == std::string_view::npos || colon == 0) break;
        int value = 0;
        const char* end = place.data() + place.size();
        const auto [stop, error] = std::from_chars(place.data() + colon + 1, end, value);
        if (error != std::errc() || stop != end || value < 1) break;
        out.numbers.insert(out.numbers.begin(), value);
        place.remove_suffix(place.size() - colon);
    }
    out.file = place;
    return out;
}

ordered_json location_json(const FileValidation& file, const Finding& f) {
    const LinePlace line = line_place(f.place);
    if (!line.numbers.empty()) {
        ordered_json region{{"startLine", line.numbers[0]}};
        if (line.numbers.size() > 1) region["startColumn"] = line.numbers[1];
        return {
            {"physicalLocation", {{"artifactLocation", {{"uri", uri_of(line.file)}}}, {"region", std::move(region)}}}};
    }
    // A map has no lines, but code hosts drop findings without one.
    ordered_json location{
        {"physicalLocation", {{"artifactLocation", {{"uri", uri_of(file.path)}}}, {"region", {{"startLine", 1}}}}}};
    if (!f.place.empty()) location["logicalLocations"] = {{{"fullyQualifiedName", f.place}}};
    return location;
}

ordered_json result_json(const FileValidation& file, const Finding& f, const char* baseline_state) {
    const std::string identity = uri_of(file.path) + "\n" + f.code->id() + "\n" + f.place;
    ordered_json properties = ordered_json::object();
    if (f.measured) properties["measured"] = *f.measured;
    if (f.limit) properties["limit"] = *f.limit;
    ordered_json result{
        {"ruleId", f.code->id()},
        {"ruleIndex", rule_index(*f.code)},
        {"level", severity_name(f.severity)},
        {"message", {{"text", f.message + figures_text(f) + " — " + f.code->hint}}},
        {"locations", ordered_json::array({location_json(file, f)})},
        {"partialFingerprints",
         {{"dgmFinding/v1", formats::to_hex(formats::hash_bytes(std::as_bytes(std::span(identity))))}}}};
    if (baseline_state != nullptr) result["baselineState"] = baseline_state;
    if (!properties.empty()) result["properties"] = std::move(properties);
    return result;
}
}  // namespace

std::string to_sarif(std::span<const FileValidation> files, const OutputOptions& options) {
    ordered_json results = ordered_json::array();
    for (const FileValidation& file : files) {
        for (const Finding* f : listed(file, options))
            results.push_back(result_json(file, *f, options.has_baseline ? "new" : nullptr));
        for (const Finding& f : file.known) results.push_back(result_json(file, f, "unchanged"));
    }
    ordered_json driver{{"name", "dgm-validate"}, {"version", options.version}};
    if (!options.homepage.empty()) driver["informationUri"] = options.homepage;
    driver["rules"] = rules_json();
    const ordered_json whole{
        {"$schema", "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"},
        {"version", "2.1.0"},
        {"runs", ordered_json::array({{{"tool", {{"driver", std::move(driver)}}}, {"results", std::move(results)}}})}};
    return whole.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace dgm::validate
