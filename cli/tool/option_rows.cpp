// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/option_rows.cpp
#include "tool/option_rows.h"

#include <algorithm>
#include <iterator>
#include <string_view>

namespace dgm::tool {
namespace {

/// The value of an option, without the rules that CLI11 adds behind a colon ("N:INT in [1 - 8]").
std::string value_of(const CLI::Option& option) {
    if (option.get_items_expected_max() == 0) return {};
    const std::string type = option.get_type_name();
    return type.substr(0, type.find(':'));
}

/// The description and the default that CLI11 has kept, unless the description names one: "samples a side [65]".
std::string text_of(const CLI::Option& option) {
    std::string out = option.get_description(), value = option.get_default_str();
    if (value.starts_with('[') && value.ends_with(']')) value = value.substr(1, value.size() - 2);  // a list
    if (!value.empty() && !out.ends_with(']')) out += " [" + value + "]";
    return out;
}

std::vector<OptionRow> rows_of(const CLI::App& app, bool arguments) {
    std::vector<OptionRow> out;
    for (const CLI::Option* option : app.get_options()) {
        if (option->get_group().empty() || option->get_positional() != arguments) continue;
        OptionRow& row = out.emplace_back();
        for (const std::string& name : option->get_snames()) row.names.push_back("-" + name);
        for (const std::string& name : option->get_lnames()) row.names.push_back("--" + name);
        if (arguments) row.names = {option->get_name(true) + (option->get_expected_max() > 1 ? "..." : "")};
        row.value = arguments ? std::string() : value_of(*option);
        row.text = text_of(*option);
        row.group = option->get_group();
    }
    return out;
}

}  // namespace

std::vector<OptionRow> option_rows(const CLI::App& app) {
    return rows_of(app, false);
}

std::vector<OptionRow> argument_rows(const CLI::App& app) {
    return rows_of(app, true);
}

std::vector<std::string> listed_words(const OptionRow& row) {
    std::vector<std::string> out;
    if (row.value.find('|') == std::string::npos) return out;
    std::string_view rest = row.value;
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

bool takes_file(const OptionRow& row) {
    constexpr std::string_view kFiles[] = {"FILE", "MESH", "DIR"};
    return std::any_of(std::begin(kFiles), std::end(kFiles),
                       [&](std::string_view word) { return row.value.find(word) != std::string::npos; });
}

std::vector<std::string> groups_of(const std::vector<OptionRow>& rows) {
    std::vector<std::string> out;
    for (const OptionRow& row : rows)
        if (std::find(out.begin(), out.end(), row.group) == out.end()) out.push_back(row.group);
    return out;
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App* command) { return !command->get_name().empty(); });
}

}  // namespace dgm::tool
