// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/report_checks.cpp
// Written against the report's keys rather than its struct: what stands in a file may be anything.
#include "validate/report_checks.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "model/codes.h"

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
    void topology(const Topology& t) {
        const json& claimed = member(report_, "map_topology");
        count(claimed, "components", static_cast<std::int64_t>(t.components), codes::kBadTopology);
        count(claimed, "boundary_loops", static_cast<std::int64_t>(t.boundary_loops), codes::kBadTopology);
        count(claimed, "genus", t.genus, codes::kBadTopology);
    }

 private:
    static std::optional<double> number(const json& value) {
        return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
    }
    [[nodiscard]] std::string place(const char* key) const { return fmt::format("/report charts[{}].{}", index_, key); }

    const json& report_;
    std::size_t index_;
    FindingList& findings_;
};

void compare_chart(const json& report, const Chart& chart, std::size_t index, const std::optional<Topology>& topology,
                   FindingList& findings) {
    ChartComparison compare(report, index, findings);
    compare.text("method", chart.method);
    compare.text("domain", chart.domain == model::Domain::kFree ? "free" : "square");
    compare.count(report, "rows", chart.rows, codes::kBadReport);
    compare.count(report, "cols", chart.cols, codes::kBadReport);
    if (topology) compare.topology(*topology);
}
}  // namespace

ClaimedError check_report(const model::MapSet& maps, std::span<const std::optional<Topology>> topologies,
                          FindingList& findings) {
    if (maps.report_json.empty()) {
        findings.warning(codes::kBadReport, "/report", "the file holds no report: nothing to compare the surface with");
        return {};
    }
    const json report = json::parse(maps.report_json, nullptr, false);
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
    const json& error = member(report, "error");
    return {magnitude(member(error, "rms")), magnitude(member(error, "hausdorff"))};
}

}  // namespace dgm::validate
