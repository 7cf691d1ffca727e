// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/option_rows.h
// Reads the options of a program as --help, man page and completion show them, so that all three show the same.
#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace dgm::tool {

/// One option, or one argument without a dash.
struct OptionRow {
    std::vector<std::string> names;  ///< "-o", "--output": as they are typed
    std::string value;               ///< "FILE|DIR"; empty for a flag
    std::string text;                ///< what it is for, with its default in brackets
    std::string group;               ///< heading in the help
};

/// The options of a program or a command, in the order of the help. Options without a group are left out.
[[nodiscard]] std::vector<OptionRow> option_rows(const CLI::App& app);

/// Its arguments: "FILE..."
[[nodiscard]] std::vector<OptionRow> argument_rows(const CLI::App& app);

/// "sample|l2|best": three words, which an option may take. Types in capitals ("FILE|DIR") stand for something else.
[[nodiscard]] std::vector<std::string> listed_words(const OptionRow& row);
/// True if the value is a file or a folder, as its type says.
[[nodiscard]] bool takes_file(const OptionRow& row);

/// The headings, in order of first use.
[[nodiscard]] std::vector<std::string> groups_of(const std::vector<OptionRow>& rows);

/// The commands of a program such as `dgm-bench bake`; none for most.
[[nodiscard]] std::vector<const CLI::App*> commands_of(const CLI::App& app);

}  // namespace dgm::tool
