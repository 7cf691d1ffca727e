// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/help.cpp
#include "tool/help.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <utility>

#include "tool/completion.h"
#include "tool/option_rows.h"
#include "tool/version.h"

namespace dgm::tool {
namespace {

constexpr std::size_t kColumns = 100, kNameColumns = 30, kIndent = 2, kSampleIndent = 6;

/// Breaks `text` into lines that end before kColumns and start at `indent`; the first one goes on where `out` stands.
/// A line break of the text stays one.
void append_wrapped(std::string& out, std::string_view text, std::size_t indent) {
    std::size_t column = indent;
    bool first = true;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find_first_of(" \n"), text.size());
        const bool breaks = !first && column + 1 + end > kColumns;
        if (breaks) out += '\n' + std::string(indent, ' ');
        if (!first && !breaks) out += ' ';
        column = (breaks || first ? indent : column + 1) + end;
        out += text.substr(0, end);
        first = false;
        if (end < text.size() && text[end] == '\n') {
            out += '\n' + std::string(indent, ' ');
            first = true;
        }
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    out += '\n';
}

/// A name on the left and its meaning on the right, below the name if that is long.
void append_entry(std::string& out, const std::string& name, std::string_view meaning) {
    std::string left = std::string(kIndent, ' ') + name;
    if (meaning.empty()) {
        out += left + '\n';
        return;
    }
    if (left.size() < kNameColumns)
        left.resize(kNameColumns, ' ');
    else
        left += '\n' + std::string(kNameColumns, ' ');
    out += left;
    append_wrapped(out, meaning, kNameColumns);
}

/// Each line of `text`, indented.
void append_lines(std::string& out, std::string_view text, std::size_t indent) {
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        out += std::string(indent, ' ') + std::string(text.substr(0, end)) + '\n';
        text.remove_prefix(std::min(end + 1, text.size()));
    }
}

std::string label(const OptionRow& row) {
    std::string out;
    for (const std::string& name : row.names) out += (out.empty() ? "" : ",") + name;
    return row.value.empty() ? out : out + " " + row.value;
}

/// "dgm-bench run" for a command, else "dgm-bench".
std::string typed_name(const CLI::App& app) {
    return (app.get_parent() == nullptr ? "" : app.get_parent()->get_name() + " ") + app.get_name();
}

/// Is a command line of the manual about this program or command?
bool is_about(std::string_view line, const std::string& name) {
    return line.starts_with(name) && (line.size() == name.size() || line[name.size()] == ' ');
}

void append_usage(std::string& out, const std::string& name, std::string_view synopsis) {
    bool first = true;
    while (!synopsis.empty()) {
        const std::size_t end = std::min(synopsis.find('\n'), synopsis.size());
        if (is_about(synopsis.substr(0, end), name)) {
            out += (first ? "Usage: " : "       ") + std::string(synopsis.substr(0, end)) + '\n';
            first = false;
        }
        synopsis.remove_prefix(std::min(end + 1, synopsis.size()));
    }
}

void append_options(std::string& out, const CLI::App& app) {
    const std::vector<OptionRow> arguments = argument_rows(app), options = option_rows(app);
    if (!arguments.empty()) out += "\nArguments:\n";
    for (const OptionRow& row : arguments) append_entry(out, label(row), row.text);
    const std::vector<const CLI::App*> commands = commands_of(app);
    if (!commands.empty()) out += "\nCommands:\n";
    for (const CLI::App* command : commands) append_entry(out, command->get_name(), command->get_description());
    if (!commands.empty())
        out += std::string(kIndent, ' ') + "The options of each: " + app.get_name() + " COMMAND --help\n";
    for (const std::string& group : groups_of(options)) {
        out += '\n' + group + ":\n";
        for (const OptionRow& row : options)
            if (row.group == group) append_entry(out, label(row), row.text);
    }
}

void append_section(std::string& out, const Section& section, const std::string& program) {
    out += '\n' + std::string(section.title) + ":\n" + std::string(kIndent, ' ');
    append_wrapped(out, section.text, kIndent);
    append_lines(out, section.sample, kSampleIndent);
    std::string keys;
    for (const Term& term : section.terms) keys += (keys.empty() ? "Keys: " : ", ") + std::string(term.name);
    keys += ". Their meanings: man " + program + ", or " + std::string(section.where);
    out += std::string(kIndent, ' ');
    append_wrapped(out, keys, kIndent);
}

void append_examples(std::string& out, const std::string& name, std::span<const Example> examples) {
    out += "\nExamples:\n";
    for (const Example& example : examples) {
        if (!is_about(example.command, name)) continue;
        out += std::string(kIndent, ' ') + std::string(example.command) + '\n' + std::string(kSampleIndent, ' ');
        append_wrapped(out, example.what, kSampleIndent);
    }
}

class Formatter : public CLI::FormatterBase {
 public:
    explicit Formatter(const Manual& manual) : manual_(manual) {}
    std::string make_help(const CLI::App* app, std::string /*name*/, CLI::AppFormatMode /*mode*/) const override {
        return help_text(*app, manual_);
    }

 private:
    const Manual manual_;
};

}  // namespace

std::string help_text(const CLI::App& app, const Manual& manual) {
    const std::string name = typed_name(app);
    const bool is_command = app.get_parent() != nullptr;
    const std::string& program = is_command ? app.get_parent()->get_name() : app.get_name();
    std::string out;
    std::string description = app.get_description();
    if (is_command && !description.empty() && description[0] >= 'a' && description[0] <= 'z')
        description[0] = static_cast<char>(description[0] - 'a' + 'A');
    append_wrapped(out, description + (description.ends_with('.') ? "" : "."), 0);
    out += '\n';
    append_usage(out, name, manual.synopsis);
    append_options(out, app);
    for (const Section& section : manual.sections) append_section(out, section, program);
    append_examples(out, name, manual.examples);
    out += "\nFiles:\n";
    for (const Term& term : manual.files) append_entry(out, std::string(term.name), term.meaning);
    out += "\nEnvironment:\n";
    for (const Term& term : manual.environment) append_entry(out, std::string(term.name), term.meaning);
    if (manual.environment.empty()) append_lines(out, kNoEnvironment, kIndent);
    out += "\nExit codes:\n";
    append_lines(out, manual.exit_codes, kIndent);
    return out;
}

void present(CLI::App& app, const std::string& program, const Manual& manual) {
    app.name(program);
    const auto formatter = std::make_shared<Formatter>(manual);
    std::vector<CLI::App*> apps = app.get_subcommands([](CLI::App*) { return true; });
    apps.push_back(&app);
    for (CLI::App* each : apps) {
        each->formatter(formatter);
        each->set_help_flag("-h,--help", "show this and stop")->group(kWhatItTells);
    }
    app.set_version_flag("-V,--version", version_line(program), "show the version and stop")->group(kWhatItTells);
}

std::string unknown_option(const CLI::App& app, std::string_view option) {
    const std::string_view name = option.substr(0, option.find('='));
    std::string out = "there is no option " + std::string(name);
    std::vector<std::string> names;
    const auto add = [&](const CLI::App& from) {
        for (OptionRow& row : option_rows(from))
            for (std::string& its : row.names) names.push_back(std::move(its));
    };
    add(app);
    std::string typed = app.get_name();
    for (const CLI::App* command : app.get_subcommands()) {  // those that were typed
        add(*command);
        typed += " " + command->get_name();
    }
    std::string_view meant = nearest(name, names);
    if (meant.empty() && name.size() > 4)  // a beginning, or a word of a longer name: --report-fmt, --error
        for (const std::string& other : names)
            if (other.starts_with(name) || other.find(name.substr(2)) != std::string::npos) {
                meant = other;
                break;
            }
    if (!meant.empty()) out += "; did you mean " + std::string(meant) + "?";
    return out + "\nsee all with: " + typed + " --help";
}

std::string missing_argument(std::string_view name, const Manual& manual) {
    std::string out = std::string(name) + " is required";
    if (!manual.examples.empty()) out += "; for instance: " + std::string(manual.examples.front().command);
    return out;
}

bool print_manual(int argc, const char* const* argv, const CLI::App& app, const Manual& manual) {
    if (argc != 2) return false;
    const std::string_view argument = argv[1];
    std::string text;
    if (argument == "--print-man")
        text = man_page(app, manual, kVersion);
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
