// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/help.h
// Everything about a program that follows from its options: help with examples, man page, shell completion, and which
// option was meant. Written once, so that none of them tells of an option that is not there.
#pragma once
#include <CLI/CLI.hpp>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace dgm::tool {

struct Example {
    std::string_view command, what;
};

/// What a man page has beside the options.
struct Manual {
    std::string_view synopsis;  ///< "dgm-info FILE..."
    std::span<const Example> examples;
    std::string_view exit_codes;  ///< one line a code: "0  ok"
    std::string_view see_also;    ///< "dgm-bake(1), dgm-validate(1)"
};

/// Edits (insert, delete, replace) from one word to the other [Levenshtein 1966].
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// The word of `words` that was meant by a mistyped one: at most two slips away. Empty if there is none.
[[nodiscard]] std::string_view nearest(std::string_view word, const std::vector<std::string>& words);

/// For a word that is not one of `words`: `there is no method "lcsm"; did you mean lscm?`, then a line with all of
/// them.
[[nodiscard]] std::string unknown_word(std::string_view what, std::string_view word,
                                       const std::vector<std::string>& words);

/// For an option that the program does not have: "there is no option --siez; did you mean --size?".
[[nodiscard]] std::string unknown_option(const CLI::App& app, std::string_view option);

/// Help with descriptions that stay inside a terminal of 100 columns; for CLI::App::formatter().
[[nodiscard]] std::shared_ptr<CLI::FormatterBase> help_formatter();

/// The text below the options in --help: examples and exit codes.
[[nodiscard]] std::string help_footer(const Manual& manual);

/// A page for man(1), section 1, in the man macros of groff.
[[nodiscard]] std::string man_page(const CLI::App& app, const Manual& manual, std::string_view version);

/// A completion for bash (completion.h has those of zsh and fish): option names, the words of options whose type lists
/// them (`sample|l2|best`), file names elsewhere.
[[nodiscard]] std::string bash_completion(const CLI::App& app);

/// Prints the man page for `--print-man` and a completion for `--print-completion`, `--print-completion=zsh` or
/// `--print-completion=fish`, if that is the only argument: what the build calls. @return false if it is not
[[nodiscard]] bool print_manual(int argc, const char* const* argv, const CLI::App& app, const Manual& manual,
                                std::string_view version);

}  // namespace dgm::tool
