// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/report_checks.cpp
// Written against the report's keys rather than its struct: a file may contain anything.
#include "validate/report_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>

#include "files/nesting.h"
#include "math/portable.h"
#include "model/codes.h"
#include "process/json_apart.h"

namespace dgm::validate {
namespace {
using bake::Topology;
using model::Chart;
using nlohmann::json;
namespace codes = model::codes;

/// The member `key` of an object; null if there is none.
const json& member(const json& object, const char* key) {
    static const json kNull;
    if (!object.is_object()) return kNull;
    const auto found = object.find(key);
    return found == object.end() ? kNull : *found;
}

/// A non-negative number, or nothing.
std::optional<double> magnitude(const json& value) {
    if (!value.is_number()) return std::nullopt;
    const double number = value.get<double>();
    return std::isfinite(number) && number >= 0 ? std::optional(number) : std::nullopt;
}

std::optional<double> number(const json& value) {
    return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

class ChartComparison {
 public:
    ChartComparison(const json& report, std::size_t chart_index, FindingList& findings)
        : report_(report), index_(chart_index), findings_(findings) {}

    void text(const char* key, const std::string& is) {
        const json& claimed = member(report_, key);
        if (claimed.is_string() && claimed.get_ref<const std::string&>() != is)
            findings_.error(
                codes::kBadReport, place(key),
                fmt::format("the report says {} `{}`, the chart `{}`", key, claimed.get_ref<const std::string&>(), is));
    }
    void count(const json& object, const char* key, std::int64_t is, const model::Code& code) {
        const std::optional<double> claimed = number(member(object, key));
        if (claimed && *claimed != static_cast<double>(is))
            findings_.error(code, place(key), fmt::format("the report says {} {}, the chart has {}", key, *claimed, is),
                            {static_cast<double>(is), *claimed});
    }
    /// A figure that the file shows as well, or that can have one value only.
    void figure(const json& object, const char* key, double is, double tolerance) {
        const json& claimed = member(object, key);
        if (!claimed.is_number()) return;
        const double number = claimed.get<double>();
        if (!(std::abs(number - is) <= tolerance))
            findings_.error(codes::kBadReport, place(key),
                            fmt::format("the report says {} {}, the file has {}", key, number, is), {number, is});
    }
    void topology(const Topology& t) {
        const json& claimed = member(report_, "map_topology");
        count(claimed, "components", static_cast<std::int64_t>(t.components), codes::kBadTopology);
        count(claimed, "boundary_loops", static_cast<std::int64_t>(t.boundary_loops), codes::kBadTopology);
        count(claimed, "genus", t.genus, codes::kBadTopology);
        const json& side = member(claimed, "oriented");
        if (side.is_boolean() && side.get<bool>() != t.oriented)
            findings_.error(codes::kBadTopology, place("oriented"),
                            fmt::format("the report says {}, the chart {}", side.get<bool>() ? "two sides" : "one side",
                                        t.oriented ? "has two" : "has one"));
        const json& source = member(report_, "source_topology");
        for (const char* key : {"components", "boundary_loops", "genus"})
            if (member(source, key).is_number() && member(claimed, key).is_number() &&
                member(source, key) != member(claimed, key))
                findings_.error(codes::kTopologyDiffers, place(("source_topology." + std::string(key)).c_str()),
                                fmt::format("the source has {} {}, its map {}", key, member(source, key).dump(),
                                            member(claimed, key).dump()),
                                {number(member(claimed, key)), number(member(source, key))});
    }
    /// The map of a bake turns no triangle over, whatever the method.
    void map_metrics() {
        const json& map = member(report_, "map");
        for (const char* key : {"flips", "degenerate", "not_finite"}) {
            const std::optional<double> claimed = number(member(map, key));
            if (claimed && *claimed != 0)
                findings_.error(codes::kFlippedFaces, place(("map." + std::string(key)).c_str()),
                                "the report counts them, a map has none", {*claimed, 0});
        }
        // Isometric is the best there is: 1 for each of them. 0 stands for a surface without area.
        for (const char* key : {"stretch_l2", "stretch_linf", "symmetric_dirichlet", "angle", "area"}) {
            const std::optional<double> claimed = number(member(map, key));
            if (claimed && *claimed != 0 && !(*claimed >= 1 - 1e-6))
                findings_.error(codes::kBadReport, place(("map." + std::string(key)).c_str()), "no map has less than 1",
                                {*claimed, 1});
        }
    }

 private:
    [[nodiscard]] std::string place(const char* key) const { return fmt::format("/report charts[{}].{}", index_, key); }

    const json& report_;
    std::size_t index_;
    FindingList& findings_;
};

/// Share of the grid's samples that lie on the surface.
double utilisation(const Chart& chart) {
    const model::Layer* mask = chart.find("mask");
    if (mask == nullptr || mask->bytes.empty()) return 1;
    const auto on = std::count(mask->bytes.begin(), mask->bytes.end(), std::byte{1});
    return static_cast<double>(on) / static_cast<double>(mask->bytes.size());
}

/// Values that an error object states twice have to agree.
void compare_error(const json& error, const std::string& place, FindingList& findings) {
    const auto expect = [&](const char* key, std::optional<double> wanted) {
        const std::optional<double> is = magnitude(member(error, key));
        if (is && wanted && !(std::abs(*is - *wanted) <= 1e-9 * std::max(*is, *wanted)))
            findings.error(codes::kBadReport, place + "." + key, "the figure contradicts the others of its kind",
                           {*is, *wanted});
    };
    const auto get = [&](const char* key) { return magnitude(member(error, key)); };
    const std::optional<double> diagonal = get("diagonal");
    for (const std::string kind : {"rms", "hausdorff"}) {
        const auto forward = get((kind + "_forward").c_str()), backward = get((kind + "_backward").c_str());
        const auto both = get(kind.c_str());
        if (forward && backward) expect(kind.c_str(), std::max(*forward, *backward));
        if (both && diagonal && *diagonal > 0) expect((kind + "_percent").c_str(), 100 * *both / *diagonal);
    }
    const auto rms = get("rms"), hausdorff = get("hausdorff");
    if (rms && diagonal && *diagonal > 0)
        expect("psnr", std::min(300.0, *rms > 0 ? 20 * math::log10(*diagonal / *rms) : 300.0));
    if (rms && hausdorff && *rms > *hausdorff * (1 + 1e-9))
        findings.error(codes::kBadReport, place + ".rms", "the mean is above the largest distance", {*rms, *hausdorff});
}

/// Same input, same bytes: no times of the run and no folders of the machine. An untrusted report may be nested without
/// end and full of faults: levels deeper than any report of ours are skipped, and a few findings are enough.
void check_reproducible(const json& value, const std::string& place, FindingList& findings, std::size_t most,
                        int depth = 0) {
    constexpr int kDeepest = 12;
    if (depth > kDeepest || findings.size() >= most) return;
    if (value.is_object()) {
        for (const auto& [key, inner] : value.items()) {
            std::string inner_place = place;
            inner_place += place.ends_with("/report") ? " " : ".";
            inner_place += key;
            if (findings.size() >= most) return;
            if (key.ends_with("seconds") || key == "times" || key == "date" || key == "time" || key == "host" ||
                key == "user" || key.starts_with("peak_memory"))
                findings.error(codes::kNotReproducible, inner_place, "the report holds what differs from run to run");
            else
                check_reproducible(inner, inner_place, findings, most, depth + 1);
        }
    } else if (value.is_array()) {
        for (std::size_t k = 0; k < value.size(); ++k)
            check_reproducible(value[k], fmt::format("{}[{}]", place, k), findings, most, depth + 1);
    } else if (value.is_string()) {
        const auto& text = value.get_ref<const std::string&>();
        const bool drive = text.size() > 2 && std::isalpha(static_cast<unsigned char>(text[0])) != 0 &&
                           text[1] == ':' && (text[2] == '/' || text[2] == '\\');
        if (drive || text.find(" /") != std::string::npos || (text.size() > 1 && text[0] == '/'))
            findings.warning(codes::kNotReproducible, place, "the report names a folder of the machine: " + text);
    }
}

void compare_chart(const json& report, const Chart& chart, std::size_t index, const std::optional<Topology>& topology,
                   FindingList& findings) {
    ChartComparison compare(report, index, findings);
    compare.text("method", chart.method);
    compare.text("domain", chart.domain == model::Domain::kFree ? "free" : "square");
    compare.count(report, "rows", chart.rows, codes::kBadReport);
    compare.count(report, "cols", chart.cols, codes::kBadReport);
    const model::Layer* seams = chart.find("seams");
    compare.count(report, "seam_pairs",
                  seams == nullptr || seams->shape.empty() ? 0 : static_cast<std::int64_t>(seams->shape[0]),
                  codes::kBadReport);
    compare.figure(report, "seam_gap", 0, 0);
    compare.figure(report, "utilisation", utilisation(chart), 1e-9);
    compare.map_metrics();
    if (topology) compare.topology(*topology);
}
}  // namespace

ClaimedError check_report(const model::MapSet& maps, std::span<const std::optional<Topology>> topologies,
                          FindingList& findings) {
    if (maps.report_json.empty()) {
        findings.warning(codes::kBadReport, "/report", "the file holds no report: nothing to compare the surface with");
        return {};
    }
    if (formats::too_deep_json(maps.report_json, formats::kMostNesting)) {
        findings.error(codes::kBadReport, "/report", "the report is nested too deeply");
        return {};
    }
    const json report = bake::read_map_report(maps.report_json);
    if (!report.is_object()) {
        findings.error(codes::kBadReport, "/report", "the report is not a JSON object");
        return {};
    }
    const json& charts = member(report, "charts");
    if (!charts.is_array() || charts.size() != maps.charts.size()) {
        findings.error(
            codes::kBadReport, "/report charts", "the report does not have one entry a chart",
            {charts.is_array() ? static_cast<double>(charts.size()) : 0.0, static_cast<double>(maps.charts.size())});
    } else {
        for (std::size_t k = 0; k < charts.size(); ++k)
            compare_chart(charts[k], maps.charts[k], k, topologies[k], findings);
    }
    if (const json& name = member(report, "source_name");
        name.is_string() && name.get_ref<const std::string&>() != maps.source_name)
        findings.error(codes::kBadReport, "/report source_name",
                       fmt::format("the report is of `{}`, the file of `{}`", name.get_ref<const std::string&>(),
                                   maps.source_name));
    constexpr std::size_t kEnough = 20;
    check_reproducible(report, "/report", findings, findings.size() + kEnough);
    if (charts.is_array() && charts.size() == maps.charts.size())
        for (std::size_t k = 0; k < charts.size(); ++k)
            compare_error(member(charts[k], "error"), fmt::format("/report charts[{}].error", k), findings);
    const json& error = member(report, "error");
    compare_error(error, "/report error", findings);
    return {magnitude(member(error, "rms")), magnitude(member(error, "hausdorff"))};
}

}  // namespace dgm::validate
