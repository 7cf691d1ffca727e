// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/help.h
// Makes everything that a program says about itself from its options: help, man page, shell completion. Written once,
// so that none of them names an option that is not there.
#pragma once
#include <CLI/CLI.hpp>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "tool/words.h"

namespace dgm::tool {

struct Example {
    std::string_view command, what;
};

/// A word that has a meaning: a key of a file, a name of a file, a variable of the environment.
struct Term {
    std::string_view name, meaning;
};

/// A part of the manual with a heading of its own, such as the form of an input file.
struct Section {
    std::string_view title;       ///< "Scene files"
    std::string_view text;        ///< a paragraph
    std::string_view sample;      ///< lines as they stand in such a file
    std::span<const Term> terms;  ///< keys of such a file: names in --help, meanings in the man page
    std::string_view where;       ///< the document that says more: "docs/scenes.md"
};

/// The parts of help and man page beside the options. All programs have all of them; `sections` may be empty.
struct Manual {
    std::string_view synopsis;  ///< "dgm-info FILE...", one line a way to call it
    std::span<const Section> sections;
    std::span<const Example> examples;
    std::span<const Term> files;        ///< files that it reads and writes
    std::span<const Term> environment;  ///< variables that it reads; may be empty
    std::string_view exit_codes;        ///< one line a code: "0  ok"
    std::string_view see_also;          ///< "dgm-bake(1), dgm-validate(1)"
};

/// Stands where a program has no variables.
inline constexpr std::string_view kNoEnvironment = "No variable and no locale changes a result.";

/// Headings that several programs use.
inline constexpr const char* kWhereThingsGo = "Where things go";
inline constexpr const char* kHowItRuns = "How it runs";
inline constexpr const char* kWhatItTells = "What it tells";

/// Adds options to one group of the help.
class Group {
 public:
    Group(CLI::App& app, const char* name) : app_(app), name_(name) {}

    CLI::Option* text(const char* option, const std::string& type, std::string& target, const std::string& help) const {
        return value(option, type, target, help);
    }
    template <class Number>
    CLI::Option* number(const char* option, const std::string& type, Number& target, const std::string& help) const {
        return value(option, type, target, help);
    }
    /// A path, a list, or anything else that CLI11 reads.
    template <class Value>
    CLI::Option* value(const char* option, const std::string& type, Value& target, const std::string& help) const {
        return app_.add_option(option, target, help)->group(name_)->type_name(type);
    }
    CLI::Option* flag(const char* option, bool& target, const std::string& help) const {
        return app_.add_flag(option, target, help)->group(name_);
    }
    [[nodiscard]] const char* name() const { return name_; }

 private:
    CLI::App& app_;
    const char* name_;
};

/// Names a program whose options are all declared, and gives it and its commands -h and the designed help; to the
/// program itself also -V. `manual` must outlive `app`.
void present(CLI::App& app, const std::string& program, const Manual& manual);

/// The help of a program or of one of its commands: description, usage, arguments, options by group, commands,
/// sections, examples, files, environment, exit codes. No line is longer than 100 columns unless a single word is.
[[nodiscard]] std::string help_text(const CLI::App& app, const Manual& manual);

/// For an option that the program does not have: "there is no option --siez; did you mean --size?", then how to see
/// all.
[[nodiscard]] std::string unknown_option(const CLI::App& app, std::string_view option);

/// For an argument that is missing: "FILE is required; for instance: dgm-info stomach.dgm".
[[nodiscard]] std::string missing_argument(std::string_view name, const Manual& manual);

/// A page for man(1), section 1, in the man macros of groff.
[[nodiscard]] std::string man_page(const CLI::App& app, const Manual& manual, std::string_view version);

/// A completion for bash (completion.h has those of zsh and fish): option names, the words of options whose type lists
/// them (`sample|l2|best`), file names elsewhere.
[[nodiscard]] std::string bash_completion(const CLI::App& app);

/// Prints the man page for `--print-man` and a completion for `--print-completion`, `--print-completion=zsh` or
/// `--print-completion=fish`, if that is the only argument: what the build calls. @return false if it is not
[[nodiscard]] bool print_manual(int argc, const char* const* argv, const CLI::App& app, const Manual& manual);

}  // namespace dgm::tool
