// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/man_page.cpp
#include <algorithm>

#include "tool/help.h"
#include "tool/option_rows.h"

namespace dgm::tool {
namespace {

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

std::string upper(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    return out;
}

void append_term(std::string& out, std::string_view name, std::string_view meaning) {
    out += ".TP\n.B " + roff(name) + "\n" + roff(meaning) + "\n";
}

void append_rows(std::string& out, const std::vector<OptionRow>& rows, const std::string& group) {
    for (const OptionRow& row : rows) {
        if (row.group != group) continue;
        std::string names;
        for (const std::string& typed : row.names)
            names += (names.empty() ? "" : ", ") + ("\\fB" + roff(typed) + "\\fR");
        if (!row.value.empty()) names += " \\fI" + roff(row.value) + "\\fR";
        out += ".TP\n" + names + "\n" + roff(row.text) + "\n";
    }
}

void append_arguments(std::string& out, const CLI::App& app) {
    for (const OptionRow& row : argument_rows(app))
        out += ".TP\n.I " + roff(row.names.front()) + "\n" + roff(row.text) + "\n";
}

void append_options(std::string& out, const CLI::App& app) {
    out += ".SH OPTIONS\n";
    append_arguments(out, app);
    const std::vector<OptionRow> options = option_rows(app);
    for (const std::string& group : groups_of(options)) {
        out += ".SS " + roff(group) + "\n";
        append_rows(out, options, group);
    }
    const std::vector<const CLI::App*> commands = commands_of(app);
    if (!commands.empty()) out += ".SH COMMANDS\n";
    for (const CLI::App* command : commands) {
        out += ".SS " + roff(command->get_name()) + "\n" + roff(command->get_description()) + "\n";
        append_arguments(out, *command);
        const std::vector<OptionRow> rows = option_rows(*command);
        for (const std::string& group : groups_of(rows)) append_rows(out, rows, group);
    }
}

void append_section(std::string& out, const Section& section) {
    out += ".SH " + roff(upper(section.title)) + "\n" + roff(section.text) + "\n";
    out += ".PP\n.nf\n" + roff(section.sample) + "\n.fi\n";
    for (const Term& term : section.terms) append_term(out, term.name, term.meaning);
}

}  // namespace

std::string man_page(const CLI::App& app, const Manual& manual, std::string_view version) {
    const std::string& name = app.get_name();
    // No date: the page is the same whenever it is made.
    std::string out =
        ".TH " + roff(upper(name)) + " 1 \"\" \"dgm " + roff(version) + "\" \"Deformable geometry maps\"\n";
    std::string brief = app.get_description();
    if (brief.ends_with('.')) brief.pop_back();
    if (!brief.empty() && brief[0] >= 'A' && brief[0] <= 'Z') brief[0] = static_cast<char>(brief[0] - 'A' + 'a');
    std::replace(brief.begin(), brief.end(), '\n', ' ');  // whatis takes one line
    out += ".SH NAME\n" + roff(name) + " \\- " + roff(brief) + "\n";
    out += ".SH SYNOPSIS\n.nf\n" + roff(manual.synopsis) + "\n.fi\n";
    append_options(out, app);
    for (const Section& section : manual.sections) append_section(out, section);
    out += ".SH EXAMPLES\n";
    for (const Example& example : manual.examples) append_term(out, example.command, example.what);
    out += ".SH FILES\n";
    for (const Term& term : manual.files) append_term(out, term.name, term.meaning);
    out += ".SH ENVIRONMENT\n";
    for (const Term& term : manual.environment) append_term(out, term.name, term.meaning);
    if (manual.environment.empty()) out += roff(kNoEnvironment) + "\n";
    out += ".SH EXIT STATUS\n.nf\n" + roff(manual.exit_codes) + "\n.fi\n";
    out += ".SH SEE ALSO\n" + roff(manual.see_also) + "\n";
    return out;
}

}  // namespace dgm::tool
