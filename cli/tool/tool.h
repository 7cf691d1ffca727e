// SPDX-License-Identifier: GPL-3.0-or-later
// cli/tool/tool.h
// Shared by main() of every small program: help, version, errors as one story, exit codes (docs/design.md section 8).
#pragma once
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "model/codes.h"
#include "model/printable.h"
#include "model/shortage.h"
#include "tool/help.h"
#include "tool/version.h"

namespace dgm::tool {

/// An error as all programs tell it:
///
///     dgm-export: x.dgm: DGM1004: the layer ends beyond the file
///       at: /charts/0/normal
///       next: copy it again, or bake it again
///
/// `subject` is the file that was worked on, or empty. A fault of a file (5xxx) begins with that file.
[[nodiscard]] inline std::string error_text(const std::string& program, const std::string& subject,
                                            const model::Error& error) {
    constexpr int kFileCodes = 5;
    const bool is_about_place = subject.empty() || error.code().number / 1000 == kFileCodes;
    const std::string& about = is_about_place && !error.place().empty() ? error.place() : subject;
    using model::printable;
    std::string out = program + ": ";
    if (!about.empty()) out += printable(about) + ": ";
    if (!error.stage().empty()) out += printable(error.stage()) + ": ";
    out += error.code().id() + ": ";
    for (const char c : model::printable_lines(error.what()))
        out += c == '\n' ? std::string("\n  ") : std::string(1, c);
    if (!error.place().empty() && error.place() != about) out += "\n  at: " + printable(error.place());
    return out + "\n  next: " + printable(error.hint()) + "\n";
}

/// Prints error_text() on stderr.
inline void print_error(const std::string& program, const std::string& subject, const model::Error& error) {
    std::fputs(error_text(program, subject, error).c_str(), stderr);
}

/// Why a command line cannot be read, in words of ours.
[[nodiscard]] inline model::Error usage_error(const CLI::App& app, const Manual& manual, const CLI::ParseError& error) {
    std::string message = error.what();
    if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
        const std::vector<std::string> unknown = app.remaining(true);
        if (!unknown.empty() && unknown.front().starts_with('-')) message = unknown_option(app, unknown.front());
    } else if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
        constexpr std::string_view kEnd = " is required";
        if (message.ends_with(kEnd))
            message = missing_argument(message.substr(0, message.size() - kEnd.size()), manual);
    }
    return {model::codes::kUsage, message};
}

/// A full disk or a reader that left is an error like any other. @throws model::Error kWriteFailed
inline void finish_output() {
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
        throw model::Error(model::codes::kWriteFailed, "the output cannot be written", "stdout");
}

/// Parses the command line and runs `body`, which gets a string to name the file it works on and returns an exit code.
/// Turns what is thrown into a message and a code: model::Error its own, a wrong command line 1, what is short for now
/// 75, everything else 4. What was printed is looked after, too. Throws where there is no memory to tell of it
/// (guarded_main.h). With --print-man or --print-completion alone, prints that.
template <class Body>
int run_tool(const std::string& program, int argc, char** argv, CLI::App& app, const Manual& manual, Body body) {
    std::string subject;
    try {
        present(app, program, manual);
        if (print_manual(argc, argv, app, manual)) {
            finish_output();
            return 0;
        }
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            if (error.get_exit_code() == 0) {
                app.exit(error);  // --help, --version
                finish_output();
                return 0;
            }
            print_error(program, {}, usage_error(app, manual, error));
            return static_cast<int>(model::ExitCode::kUsage);
        }
        const int exit_code = body(subject);
        subject.clear();
        finish_output();
        return exit_code;
    } catch (const model::Error& error) {
        print_error(program, subject, error);
        return static_cast<int>(error.code().exit);
    } catch (const std::exception& other) {
        const model::Error error = model::error_of(other);
        print_error(program, subject, error);
        return static_cast<int>(error.code().exit);
    } catch (...) { std::fputs("internal error\n", stderr); }
    return static_cast<int>(model::ExitCode::kInternal);
}

}  // namespace dgm::tool
