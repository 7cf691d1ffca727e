// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/html_page.cpp
#include "bench/html_page.h"

#include <array>
#include <string_view>
#include <utility>

#include "bench/run_files.h"

namespace dgm::bench {
namespace {

/// Nothing in it can end the script element that holds it.
std::string for_script(const std::string& json) {
    std::string out;
    out.reserve(json.size());
    for (const char c : json) {
        if (c == '<')
            out += "\\u003c";
        else
            out += c;
    }
    return out;
}

}  // namespace

std::string to_html(const Run& run) {
    const std::string title = "dgm-bench " + run.command + ": speed against error";
    const std::string data = for_script(to_json(run));
    const std::array<std::pair<std::string_view, std::string_view>, 5> parts{{{"@TITLE@", title},
                                                                              {"@CSS@", page::kCss},
                                                                              {"@DATA@", data},
                                                                              {"@D3@", page::kD3},
                                                                              {"@SCRIPT@", page::kScript}}};
    // One pass from left to right: inserted text is not searched again.
    std::string out;
    std::string_view left = page::kHtml;
    while (!left.empty()) {
        std::size_t at = left.size();
        const std::pair<std::string_view, std::string_view>* next = nullptr;
        for (const auto& part : parts)
            if (const std::size_t found = left.find(part.first); found < at) {
                at = found;
                next = &part;
            }
        out += left.substr(0, at);
        if (next == nullptr) break;
        out += next->second;
        left.remove_prefix(at + next->first.size());
    }
    return out;
}

}  // namespace dgm::bench
