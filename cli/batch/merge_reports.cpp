// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/merge_reports.cpp
#include "batch/merge_reports.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "batch/batch_report_json.h"
#include "model/codes.h"
#include "process/json_apart.h"

namespace dgm::bake {
namespace {

using nlohmann::json;
namespace codes = model::codes;

[[noreturn]] void not_a_report(const NamedReport& report, const std::string& why) {
    throw model::Error(codes::kReportUnreadable, why, report.name);
}

std::string text_in(const json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

bool is_true(const json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_boolean() && found->get<bool>();
}

/// Text to compare by, whatever bytes its strings have.
std::string text_of(const json& value) {
    return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

int exit_of(const json& asset) {
    if (text_in(asset, "outcome") == name_of(Outcome::kInterrupted))
        return static_cast<int>(model::ExitCode::kInterrupted);
    const auto error = asset.find("error");
    if (error == asset.end() || !error->is_object()) return 0;
    const auto exit = error->find("exit_code");
    if (exit != error->end() && exit->is_number_integer())
        for (const model::Code* code : codes::kAll)
            if (static_cast<std::int64_t>(code->exit) == exit->get<std::int64_t>()) return static_cast<int>(code->exit);
    return static_cast<int>(model::ExitCode::kInternal);
}

/// Smaller is better.
int rank_of(const json& asset) {
    const std::string outcome = text_in(asset, "outcome");
    const auto place =
        std::find_if(kOutcomes.begin(), kOutcomes.end(), [&](Outcome o) { return name_of(o) == outcome; });
    const int rank = 2 * static_cast<int>(place - kOutcomes.begin());
    return rank + (exit_of(asset) == static_cast<int>(model::ExitCode::kTransient) ? 1 : 0);
}

void check(const NamedReport& report) {
    const json& object = report.report;
    if (!object.is_object()) not_a_report(report, "it is not a JSON object; was its batch interrupted?");
    const auto version = object.find("report_version");
    if (version == object.end() || !version->is_number_integer())
        not_a_report(report, "it has no report_version: it is not a report of dgm-bake --report");
    if (version->get<std::int64_t>() != kReportVersion)
        not_a_report(report, "it is a report of another version; write it again with the installed dgm-bake");
    const auto assets = object.find("assets");
    if (assets == object.end() || !assets->is_array()) not_a_report(report, "it has no list of assets");
    for (const json& asset : *assets) {
        const std::string outcome = text_in(asset, "outcome");
        if (!asset.is_object() || text_in(asset, "source").empty() ||
            std::none_of(kOutcomes.begin(), kOutcomes.end(), [&](Outcome o) { return name_of(o) == outcome; }))
            not_a_report(report, "an asset has no source or no known outcome");
    }
}

/// Files that several parts of a batch have met, once each. What one of them has removed is removed.
class OtherFiles {
 public:
    void add(const json& report) {
        for (const char* key : {"left_out", "left_over"}) {
            const auto list = report.find(key);
            if (list == report.end() || !list->is_array()) continue;
            for (const json& file : *list) {
                if (!file.is_object()) continue;
                const auto [place, is_new] = files_[key].try_emplace(text_in(file, "path"), file);
                if (!is_new && is_true(file, "removed")) place->second = file;
            }
        }
    }
    void put(json& report) const {
        for (const auto& [key, files] : files_)
            for (const auto& [path, file] : files) report[key].push_back(file);
    }

 private:
    std::map<std::string, std::map<std::string, json>> files_;
};

}  // namespace

MergedReport merge_reports(std::vector<NamedReport> reports) {
    if (reports.empty()) throw model::Error(codes::kUsage, "name the reports to merge");
    using Key = std::tuple<std::string, std::string>;  // source, outputs asked for
    std::map<Key, std::tuple<int, std::string, json>> assets;
    std::set<std::string> generators;
    std::set<json> runs;
    OtherFiles others;
    for (NamedReport& report : reports) {
        check(report);
        json& object = report.report;
        if (text_in(object, "generator").empty()) not_a_report(report, "it does not say what wrote it");
        generators.insert(text_in(object, "generator"));
        others.add(object);
        runs.insert(object.contains("run") ? object["run"] : json(nullptr));
        for (json& asset : object["assets"]) {
            const Key key{text_in(asset, "source"),
                          asset.contains("outputs") ? text_of(asset["outputs"]) : std::string()};
            std::tuple<int, std::string, json> entry{rank_of(asset), text_of(asset), asset};
            const auto [place, is_new] = assets.try_emplace(key, entry);
            if (!is_new && std::tie(std::get<0>(entry), std::get<1>(entry)) <
                               std::tie(std::get<0>(place->second), std::get<1>(place->second)))
                place->second = std::move(entry);
        }
    }
    if (generators.size() > 1)
        throw model::Error(codes::kReportUnreadable,
                           "the reports are of different versions: " + *generators.begin() + " and " +
                               *generators.rbegin() + "; bake all shards with the same one",
                           reports.front().name);
    model::ExitCode worst = model::ExitCode::kOk;
    std::map<std::string, std::uint64_t> counts;
    json list = json::array();
    for (auto& [key, entry] : assets) {
        json& asset = std::get<json>(entry);
        worst = model::worse(worst, static_cast<model::ExitCode>(exit_of(asset)));
        ++counts[text_in(asset, "outcome")];
        list.push_back(std::move(asset));
    }
    json out = report_frame(*generators.begin(), worst);
    for (const Outcome outcome : kOutcomes) set_count(out, outcome, counts[std::string(name_of(outcome))]);
    out["summary"]["assets"] = list.size();
    if (runs.size() == 1 && !runs.begin()->is_null()) out["run"] = *runs.begin();
    out["assets"] = std::move(list);
    others.put(out);
    return {out.dump(2, ' ', false, json::error_handler_t::replace) + '\n', worst};
}

}  // namespace dgm::bake
