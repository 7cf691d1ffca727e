// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/dependency_file.cpp
// [Make] GNU Make manual, sections 4.3 and 6.1: what must be escaped, and how. [Ninja] src/depfile_parser.in.cc.
#include "batch/dependency_file.h"

#include <set>

#include "model/codes.h"

namespace dgm::bake {
namespace {

std::string escaped(const std::filesystem::path& path) {
    std::string out;
    std::size_t backslashes = 0;
    for (const char c : path.native()) {
        if (c == '\n' || c == '\r')
            throw model::Error(model::codes::kUnsupported, "Make and Ninja cannot read names with line breaks",
                               path.string());
        if (c == ' ' || c == '\t' || c == '#') {
            // Backslashes in front of an escaped character count in pairs, anywhere else one by one.
            out.append(backslashes, '\\');
            out += '\\';
        } else if (c == '$') {
            out += '$';
        }
        out += c;
        backslashes = c == '\\' ? backslashes + 1 : 0;
    }
    return out;
}

}  // namespace

std::string dependency_file(const std::vector<DependencyRule>& rules) {
    std::string out;
    std::set<std::string> further;
    for (const DependencyRule& rule : rules) {
        if (rule.outputs.empty()) continue;
        for (std::size_t k = 0; k < rule.outputs.size(); ++k) out += (k == 0 ? "" : " ") + escaped(rule.outputs[k]);
        out += ':';
        for (std::size_t k = 0; k < rule.inputs.size(); ++k) {
            out += " \\\n  " + escaped(rule.inputs[k]);
            if (k > 0) further.insert(escaped(rule.inputs[k]));
        }
        out += '\n';
    }
    for (const std::string& input : further) out += '\n' + input + ":\n";
    return out;
}

}  // namespace dgm::bake
