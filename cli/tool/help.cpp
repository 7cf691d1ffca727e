// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/help.cpp
#include "tool/help.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <utility>

#include "tool/completion.h"
#include "tool/option_list.h"

namespace dgm::tool {
namespace {

std::vector<std::string> option_names(const CLI::App& app) {
    std::vector<std::string> out;
    for (const CLI::Option* option : shown_options(app))
        for (std::string& name : typed_names(*option)) out.push_back(std::move(name));
    return out;
}

/// Text for roff: no escapes, no requests by accident; a hyphen that stays one when copied.
std::string roff(std::string_view text) {
    std::string out;
    bool line_start = true;
    for (const char c : text) {
        if (line_start && (c == '.' || c == '\'')) out += "\\&";
        if (c == '\\')
            out += "\\e";
        else if (c == '-')
            out += "\\-";
        else
            out += c;
        line_start = c == '\n';
    }
    return out;
}

void append_positionals(std::string& out, const CLI::App& app) {
    for (const CLI::Option* option : app.get_options())
        if (option->get_positional() && !option->get_group().empty())
            out += ".TP\n.I " + roff(option->get_name(true)) + "\n" + roff(option->get_description()) + "\n";
}

void append_option(std::string& out, const CLI::Option& option) {
    std::string names;
    for (const std::string& typed : typed_names(option))
        names += (names.empty() ? "" : ", ") + ("\\fB" + roff(typed) + "\\fR");
    if (takes_value(option)) names += " \\fI" + roff(option.get_type_name()) + "\\fR";
    out += ".TP\n" + names + "\n" + roff(option.get_description()) + "\n";
}

/// The words after `--` of a program or of one of its commands, and for bash the cases of options that take a value.
struct Completion {
    std::string words, cases;
};

Completion completion_of(const CLI::App& app) {
    Completion out;
    for (const CLI::Option* option : shown_options(app)) {
        std::string pattern;
        for (const std::string& typed : typed_names(*option)) {
            out.words += (out.words.empty() ? "" : " ") + typed;
            pattern += (pattern.empty() ? "" : "|") + typed;
        }
        if (!takes_value(*option)) continue;
        const std::vector<std::string> listed = listed_words(option->get_type_name());
        const bool is_file = takes_file(*option);
        out.cases += "        " + pattern + ") ";
        if (!listed.empty())
            out.cases += fmt::format("COMPREPLY=($(compgen -W \"{}\" -- \"$current\"))", fmt::join(listed, " "));
        else
            out.cases +=
                is_file
                    ? "local IFS=$'\\n'; COMPREPLY=($(compgen -f -- \"$current\")); compopt -o filenames 2>/dev/null"
                    : "COMPREPLY=()";
        out.cases += "; return ;;\n";
    }
    return out;
}

constexpr std::size_t kHelpColumns = 100, kNameColumns = 30;

class Formatter : public CLI::Formatter {
 public:
    Formatter() { column_width(kNameColumns); }
    [[nodiscard]] std::string make_option_desc(const CLI::Option* option) const override {
        const std::string whole = CLI::Formatter::make_option_desc(option);
        std::string out;
        std::size_t column = 0, begin = 0;
        while (begin < whole.size()) {
            const std::size_t end = std::min(whole.find(' ', begin), whole.size());
            const bool breaks = column > 0 && column + 1 + end - begin > kHelpColumns - kNameColumns;
            if (column > 0) out += breaks ? '\n' : ' ';
            column = (breaks || column == 0 ? 0 : column + 1) + end - begin;
            out.append(whole, begin, end - begin);
            begin = end + 1;
        }
        return out;
    }
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> help_formatter() {
    return std::make_shared<Formatter>();
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < b.size(); ++j)
            diagonal =
                std::exchange(row[j + 1], std::min({row[j] + 1, row[j + 1] + 1, diagonal + (a[i] == b[j] ? 0 : 1)}));
    }
    return row.back();
}

std::string_view nearest(std::string_view word, const std::vector<std::string>& words) {
    constexpr std::size_t kLongest = 64;
    std::string_view best;
    std::size_t best_distance = 3;  // more than two slips is another word
    if (word.size() > kLongest) return best;
    for (const std::string& other : words) {
        const std::size_t distance = edit_distance(word, other);
        if (distance >= best_distance || distance >= std::max(word.size(), other.size())) continue;
        best = other;
        best_distance = distance;
    }
    return best;
}

std::string unknown_word(std::string_view what, std::string_view word, const std::vector<std::string>& words) {
    std::string message = fmt::format("there is no {} \"{}\"", what, word);
    if (const std::string_view meant = nearest(word, words); !meant.empty())
        message += fmt::format("; did you mean {}?", meant);
    return message + fmt::format("\nthere are: {}", fmt::join(words, ", "));
}

std::string unknown_option(const CLI::App& app, std::string_view option) {
    const std::string_view name = option.substr(0, option.find('='));
    std::string out = "there is no option " + std::string(name);
    std::vector<std::string> names = option_names(app);
    for (const CLI::App* command : app.get_subcommands())  // those that were typed
        for (std::string& its : option_names(*command)) names.push_back(std::move(its));
    std::string_view meant = nearest(name, names);
    if (meant.empty() && name.size() > 4)  // a beginning, or a word of a longer name: --report-fmt, --error
        for (const std::string& other : names)
            if (other.starts_with(name) || other.find(name.substr(2)) != std::string::npos) {
                meant = other;
                break;
            }
    if (!meant.empty()) out += "; did you mean " + std::string(meant) + "?";
    return out;
}

std::string help_footer(const Manual& manual) {
    std::string out = "Examples:\n";
    for (const Example& example : manual.examples)
        out += "  " + std::string(example.command) + "\n      " + std::string(example.what) + "\n";
    out += "\nExit codes:\n";
    std::string_view rest = manual.exit_codes;
    while (!rest.empty()) {
        const std::size_t end = std::min(rest.find('\n'), rest.size());
        out += "  " + std::string(rest.substr(0, end)) + "\n";
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return out;
}

std::string man_page(const CLI::App& app, const Manual& manual, std::string_view version) {
    const std::string& name = app.get_name();
    std::string title = name;
    for (char& c : title)
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    // No date: the page is the same whenever it is made.
    std::string out = ".TH " + roff(title) + " 1 \"\" \"dgm " + roff(version) + "\" \"Deformable geometry maps\"\n";
    std::string brief = app.get_description();
    if (brief.ends_with('.')) brief.pop_back();
    if (!brief.empty() && brief[0] >= 'A' && brief[0] <= 'Z') brief[0] = static_cast<char>(brief[0] - 'A' + 'a');
    out += ".SH NAME\n" + roff(name) + " \\- " + roff(brief) + "\n";
    out += ".SH SYNOPSIS\n.nf\n" + roff(manual.synopsis) + "\n.fi\n";
    out += ".SH OPTIONS\n";
    append_positionals(out, app);
    std::vector<std::string> groups;
    const std::vector<const CLI::Option*> options = shown_options(app);
    for (const CLI::Option* option : options)
        if (std::find(groups.begin(), groups.end(), option->get_group()) == groups.end())
            groups.push_back(option->get_group());
    for (const std::string& group : groups) {
        out += ".SS " + roff(group) + "\n";
        for (const CLI::Option* option : options)
            if (option->get_group() == group) append_option(out, *option);
    }
    const std::vector<const CLI::App*> commands = commands_of(app);
    if (!commands.empty()) out += ".SH COMMANDS\n";
    for (const CLI::App* command : commands) {
        out += ".SS " + roff(command->get_name()) + "\n" + roff(command->get_description()) + ".\n";
        append_positionals(out, *command);
        for (const CLI::Option* option : shown_options(*command)) append_option(out, *option);
    }
    out += ".SH EXAMPLES\n";
    for (const Example& example : manual.examples)
        out += ".TP\n.B " + roff(example.command) + "\n" + roff(example.what) + "\n";
    out += ".SH EXIT STATUS\n.nf\n" + roff(manual.exit_codes) + "\n.fi\n";
    out += ".SH SEE ALSO\n" + roff(manual.see_also) + "\n";
    return out;
}

std::string bash_completion(const CLI::App& app) {
    const std::string& name = app.get_name();
    std::string function = "_" + name;
    std::replace(function.begin(), function.end(), '-', '_');
    const Completion own = completion_of(app);
    std::string text = "# Completion of " + name + " for bash.\n" + function +
                       "() {\n    local current=\"$2\" previous=\"$3\" words=\"" + own.words + "\"\n" +
                       "    case \"$previous\" in\n" + own.cases + "    esac\n";
    const std::vector<const CLI::App*> commands = commands_of(app);
    std::string names;
    if (!commands.empty()) text += "    case \"${COMP_WORDS[1]}\" in\n";
    for (const CLI::App* command : commands) {
        const Completion its = completion_of(*command);
        names += (names.empty() ? "" : " ") + command->get_name();
        text += "    " + command->get_name() + ")\n    words=\"" + its.words + "\"\n    case \"$previous\" in\n" +
                its.cases + "    esac ;;\n";
    }
    if (!commands.empty())
        text +=
            "    esac\n    if [[ \"$COMP_CWORD\" == 1 && \"$current\" != -* ]]; then\n        COMPREPLY=($(compgen -W "
            "\"" +
            names + "\" -- \"$current\"))\n        return\n    fi\n";
    return text +
           "    if [[ \"$current\" == -* ]]; then\n        COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n" +
           "    else\n        local IFS=$'\\n'; COMPREPLY=($(compgen -f -- \"$current\"))\n" +
           "        compopt -o filenames 2>/dev/null\n    fi\n}\ncomplete -F " + function + " " + name + "\n";
}

bool print_manual(int argc, const char* const* argv, const CLI::App& app, const Manual& manual,
                  std::string_view version) {
    if (argc != 2) return false;
    const std::string_view argument = argv[1];
    std::string text;
    if (argument == "--print-man")
        text = man_page(app, manual, version);
    else if (argument == "--print-completion")
        text = bash_completion(app);
    else if (argument == "--print-completion=zsh")
        text = zsh_completion(app);
    else if (argument == "--print-completion=fish")
        text = fish_completion(app);
    else
        return false;
    std::fputs(text.c_str(), stdout);
    return true;
}

}  // namespace dgm::tool
