// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/completion.cpp
#include "tool/completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>
#include <vector>

#include "tool/option_list.h"

namespace dgm::tool {
namespace {

/// The first clause of an option's description, on one line: a menu has room for no more.
std::string brief(const std::string& description) {
    std::string out = description.substr(0, description.find_first_of(";\n"));
    constexpr std::size_t kMost = 100;
    if (out.size() > kMost) out = out.substr(0, out.rfind(' ', kMost)) + " ...";
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
    for (const CLI::Option* option : shown_options(app)) {
        const std::vector<std::string> names = typed_names(*option);
        std::string value;
        if (takes_value(*option)) {
            const std::string type = option->get_type_name();
            const std::vector<std::string> words = listed_words(type);
            value = ":" + zsh_text(type) + ":";
            if (!words.empty())
                value += fmt::format("({})", fmt::join(words, " "));
            else if (takes_file(*option))
                value += "_files";
        }
        for (const std::string& name : names)
            out += fmt::format("        '({}){}[{}]{}' \\\n", fmt::join(names, " "), name,
                               zsh_text(brief(option->get_description())), value);
    }
    return out;
}

std::string fish_text(const std::string& text) {
    return "'" + replaced(replaced(text, '\\', "\\\\"), '\'', "\\'") + "'";
}

std::string fish_options(const CLI::App& app, const std::string& start) {
    std::string out;
    for (const CLI::Option* option : shown_options(app)) {
        out += start;
        for (const std::string& name : option->get_snames()) out += " -s " + name;
        for (const std::string& name : option->get_lnames()) out += " -l " + name;
        const std::vector<std::string> words = listed_words(option->get_type_name());
        if (!words.empty())
            out += fmt::format(" -x -a '{}'", fmt::join(words, " "));
        else if (takes_file(*option))
            out += " -r -F";
        else if (takes_value(*option))
            out += " -x";
        out += " -d " + fish_text(brief(option->get_description())) + "\n";
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
