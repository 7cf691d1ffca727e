// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/failure_lines.cpp
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "bench/recommend.h"
#include "bench/stability_sweep.h"
#include "model/codes.h"

namespace dgm::bench {
namespace {

/// Result of one method at one level of a family.
struct Step {
    std::string level, outcome, maps;
};

std::vector<Step> steps_of(const Table& table, const std::string& family, const std::string& method) {
    std::vector<Step> out;
    for (std::size_t row = 0; row < table.rows.size(); ++row)
        if (table.text(row, "family") == family && table.text(row, "method") == method)
            out.push_back({table.text(row, "level"), table.text(row, "outcome"), table.text(row, "maps")});
    return out;
}

bool timed_out(const std::string& outcome) {
    return outcome.starts_with(model::codes::kWorkerTimeout.id());
}

/// The part that methods with the same failures share: "at 16 (DGM3006 GRID_TOO_SMALL), 5 of 6 levels baked".
struct Failure {
    std::string where;  ///< empty: there was none
    bool by_time = false;
    friend bool operator==(const Failure&, const Failure&) = default;
};

Failure failure_of(const std::vector<Step>& steps) {
    const auto failed = [](const Step& step) { return step.outcome != "ok"; };
    const auto first = std::find_if(steps.begin(), steps.end(), failed);
    if (first == steps.end()) return {};
    Failure out;
    out.by_time = timed_out(first->outcome);
    out.where = "at " + first->level + (out.by_time ? "" : " (" + first->outcome + ")") + ", " +
                std::to_string(steps.size() - static_cast<std::size_t>(std::count_if(first, steps.end(), failed))) +
                " of " + std::to_string(steps.size()) + " levels baked";
    return out;
}

/// "mvc and tutte fail at 16 ...", "arap runs out of --time-limit at 100 ...", "lscm bakes every level".
std::string said_of(const Failure& failure, const std::vector<std::string>& methods) {
    const char* s = methods.size() == 1 ? "s" : "";
    const std::string who = listed(methods);
    if (failure.where.empty()) return who + " bake" + s + " every level";
    return who +
           (failure.by_time ? std::string(" run") + s + " out of --time-limit " : std::string(" fail") + s + " ") +
           failure.where;
}

/// "takes stretch, from 16 on arap"; a level that fails ends the list of the methods taken before.
std::string story_of_auto(const std::vector<Step>& steps) {
    std::string out, last;
    for (const Step& step : steps) {
        const std::string now = step.outcome == "ok"      ? step.maps
                                : timed_out(step.outcome) ? "nothing in time"
                                                          : "nothing (" + step.outcome + ")";
        if (now == last) continue;
        out += out.empty() ? "auto takes " + now : ", from " + step.level + " on " + now;
        last = now;
    }
    return out;
}

}  // namespace

std::vector<std::string> failure_lines(const Table& table) {
    std::vector<std::string> out;
    for (const std::string& family : values_of(table, "family")) {
        std::vector<std::pair<Failure, std::vector<std::string>>> groups{{Failure{}, {}}};  // the first: no failure
        std::string automatic;
        for (const std::string& method : values_of(table, "method")) {
            const std::vector<Step> steps = steps_of(table, family, method);
            if (steps.empty()) continue;
            if (method == "auto") {
                automatic = story_of_auto(steps);
                continue;
            }
            const Failure failure = failure_of(steps);
            auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.first == failure; });
            if (group == groups.end()) group = groups.insert(groups.end(), {failure, {}});
            group->second.push_back(method);
        }
        std::rotate(groups.begin(), groups.begin() + 1, groups.end());  // who holds, last
        std::string line = family + ": ";
        for (const auto& [failure, methods] : groups)
            if (!methods.empty()) line += said_of(failure, methods) + "; ";
        if (automatic.empty()) line.resize(line.size() - 2);
        line += automatic;
        out.push_back(line);
    }
    return out;
}

}  // namespace dgm::bench
