// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/completion_zsh_fish.cpp
#include "tool/completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "tool/option_rows.h"

namespace dgm::tool {
namespace {

/// The first clause of an option's description, on one line: a menu has room for no more.
std::string brief(const std::string& description) {
    std::string out = description.substr(0, description.find_first_of(";\n"));
    constexpr std::size_t kMost = 100;
    if (out.size() > kMost) {
        out.resize(std::min(out.size(), out.rfind(' ', kMost)));
        out += " ...";
    }
    return out;
}

std::string replaced(std::string_view text, char what, std::string_view by) {
    std::string out;
    for (const char c : text) {
        if (c == what)
            out += by;
        else
            out += c;
    }
    return out;
}

std::string zsh_text(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
        out += c;
    }
    return replaced(out, '\'', "'\\''");
}

/// The specifications of _arguments, one a line.
std::string zsh_options(const CLI::App& app) {
    std::string out;
    for (const OptionRow& row : option_rows(app)) {
        std::string value;
        if (!row.value.empty()) {
            const std::vector<std::string> words = listed_words(row);
            value = ":" + zsh_text(row.value) + ":";
            if (!words.empty())
                value += fmt::format("({})", fmt::join(words, " "));
            else if (takes_file(row))
                value += "_files";
        }
        for (const std::string& name : row.names)
            out += fmt::format("        '({}){}[{}]{}' \\\n", fmt::join(row.names, " "), name,
                               zsh_text(brief(row.text)), value);
    }
    return out;
}

std::string fish_text(const std::string& text) {
    return "'" + replaced(replaced(text, '\\', "\\\\"), '\'', "\\'") + "'";
}

std::string fish_options(const CLI::App& app, const std::string& start) {
    std::string out;
    for (const OptionRow& row : option_rows(app)) {
        out += start;
        for (const std::string& name : row.names)
            out += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
        const std::vector<std::string> words = listed_words(row);
        if (!words.empty())
            out += fmt::format(" -x -a '{}'", fmt::join(words, " "));
        else if (takes_file(row))
            out += " -r -F";
        else if (!row.value.empty())
            out += " -x";
        out += " -d " + fish_text(brief(row.text)) + "\n";
    }
    return out;
}

}  // namespace

std::string zsh_completion(const CLI::App& app) {
    const std::string& name = app.get_name();
    std::string out = "#compdef " + name + "\n_" + name + "() {\n";
    const std::vector<const CLI::App*> commands = commands_of(app);
    if (commands.empty())
        return out + "    _arguments -s -S \\\n" + zsh_options(app) + "        '*:file:_files'\n}\n_" + name +
               " \"$@\"\n";
    std::string names, cases;
    for (const CLI::App* command : commands) {
        names += (names.empty() ? "" : " ") + command->get_name();
        cases += "    " + command->get_name() + ")\n    _arguments -s -S \\\n" + zsh_options(*command) +
                 "        '*:file:_files' ;;\n";
    }
    return out + "    local state\n    _arguments -s -S \\\n" + zsh_options(app) + "        '1:command:(" + names +
           ")' '*::argument:->rest'\n    [[ $state == rest ]] || return\n    case $words[1] in\n" + cases +
           "    esac\n}\n_" + name + " \"$@\"\n";
}

std::string fish_completion(const CLI::App& app) {
    const std::string& name = app.get_name();
    const std::string start = "complete -c " + name;
    std::string out = fish_options(app, start);
    for (const CLI::App* command : commands_of(app)) {
        out += start + " -n __fish_use_subcommand -a " + command->get_name() + " -d " +
               fish_text(brief(command->get_description())) + "\n";
        out += fish_options(*command, start + " -n '__fish_seen_subcommand_from " + command->get_name() + "'");
    }
    return out;
}

}  // namespace dgm::tool
