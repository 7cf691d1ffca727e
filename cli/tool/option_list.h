// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/option_list.h
// The options of a program as they are shown: what help, man page and completions have in common.
#pragma once
#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace dgm::tool {

/// "-o", "--output": as they are typed.
[[nodiscard]] inline std::vector<std::string> typed_names(const CLI::Option& option) {
    std::vector<std::string> out;
    for (const std::string& name : option.get_snames()) out.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) out.push_back("--" + name);
    return out;
}

[[nodiscard]] inline std::vector<const CLI::Option*> shown_options(const CLI::App& app) {
    std::vector<const CLI::Option*> out;
    for (const CLI::Option* option : app.get_options())
        if (!option->get_group().empty() && !option->get_positional()) out.push_back(option);
    return out;
}

[[nodiscard]] inline bool takes_value(const CLI::Option& option) {
    return option.get_items_expected_max() > 0;
}

/// True if the value is a file or a folder, as its type says.
[[nodiscard]] inline bool takes_file(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    return takes_value(option) && (type.find("FILE") != std::string::npos || type.find("MESH") != std::string::npos ||
                                   type.find("DIR") != std::string::npos);
}

/// "sample|l2|best": three words. Types in capitals ("FILE|DIR") stand for something else.
[[nodiscard]] inline std::vector<std::string> listed_words(const std::string& type) {
    std::vector<std::string> out;
    if (type.find('|') == std::string::npos) return out;
    std::string_view rest = type;
    for (;;) {
        const std::size_t bar = rest.find('|');
        const std::string_view word = rest.substr(0, bar);
        if (word.empty() || std::any_of(word.begin(), word.end(), [](char c) { return c >= 'A' && c <= 'Z'; }))
            return {};
        out.emplace_back(word);
        if (bar == std::string_view::npos) return out;
        rest.remove_prefix(bar + 1);
    }
}

/// The commands of a program such as `dgm-bench bake`; none for most.
[[nodiscard]] inline std::vector<const CLI::App*> commands_of(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App* command) { return !command->get_name().empty(); });
}

}  // namespace dgm::tool
