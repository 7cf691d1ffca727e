// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/failure_lines.cpp
#include <algorithm>

#include "bench/stability_sweep.h"

namespace dgm::bench {
namespace {

struct MethodStory {
    std::size_t levels = 0, failed = 0;
    std::string first_failure, why, maps;
};

MethodStory story_of(const Table& table, const std::string& family, const std::string& method) {
    MethodStory out;
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
        if (table.text(row, "family") != family || table.text(row, "method") != method) continue;
        ++out.levels;
        const std::string outcome = table.text(row, "outcome"), maps = table.text(row, "maps");
        if (outcome != "ok" && out.failed++ == 0) out.first_failure = table.text(row, "level"), out.why = outcome;
        if (!maps.empty() && out.maps.find(maps) == std::string::npos)
            out.maps += (out.maps.empty() ? "" : ", ") + maps;
    }
    return out;
}

}  // namespace

std::vector<std::string> failure_lines(const Table& table) {
    std::vector<std::string> out;
    for (const std::string& family : values_of(table, "family")) {
        std::string line = family + ": ", holds;
        std::string automatic;
        for (const std::string& method : values_of(table, "method")) {
            const MethodStory story = story_of(table, family, method);
            if (story.levels == 0) continue;
            if (method == "auto") {
                automatic = story.failed == 0 ? "; auto holds by " + story.maps
                                              : "; auto fails at " + story.first_failure + " (" + story.why + ")";
                continue;
            }
            if (story.failed == 0)
                holds += (holds.empty() ? "" : ", ") + method;
            else
                line += method + " fails at " + story.first_failure + " (" + story.why + "), " +
                        std::to_string(story.levels - story.failed) + " of " + std::to_string(story.levels) +
                        " levels baked; ";
        }
        line += holds.empty() ? "no named method holds everywhere" : "hold everywhere: " + holds;
        out.push_back(line + automatic);
    }
    return out;
}

}  // namespace dgm::bench
