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
#include "tool/help.h"

namespace dgm::tool {

inline constexpr const char* kVersion = DGM_VERSION;

/// "dgm-export 0.1.0"
[[nodiscard]] inline std::string version_line(const std::string& program) {
    return program + " " + kVersion;
}

/// "dgm-export: x.dgm: DGM1003: stored bytes differ ... (/charts/0/normal)\n  next: ...\n" on stderr. `subject` is the
/// file that was worked on, or empty.
inline void print_error(const std::string& program, const std::string& subject, const model::Error& error) {
    std::string line = program + ": ";
    if (!subject.empty()) line += subject + ": ";
    if (!error.stage().empty()) line += error.stage() + ": ";
    line += error.code().id() + ": " + error.what();
    if (!error.place().empty() && error.place() != subject) line += " (" + error.place() + ")";
    std::fprintf(stderr, "%s\n  next: %s\n", line.c_str(), error.hint());
}

/// Parses the command line and runs `body`, which gets a string to name the file it works on and returns an exit code.
/// Turns what is thrown into a message and a code: model::Error its own, a wrong command line 1, no memory and
/// everything else 4. --help shows the manual's examples; with --print-man or --print-completion alone, prints that.
template <class Body>
int run_tool(const std::string& program, int argc, char** argv, CLI::App& app, const Manual& manual,
             Body body) noexcept {
    std::string subject;
    try {
        app.name(program);
        app.set_version_flag("-V,--version", version_line(program), "Print the version and exit");
        app.formatter(help_formatter());
        for (CLI::App* command : app.get_subcommands({})) command->formatter(help_formatter());
        if (!manual.examples.empty()) app.footer(help_footer(manual));
        if (print_manual(argc, argv, app, manual, kVersion)) return 0;
        try {
            app.parse(argc, argv);
        } catch (const CLI::ExtrasError& error) {
            const std::vector<std::string> unknown = app.remaining(true);
            const bool is_option = !unknown.empty() && unknown.front().starts_with('-');
            print_error(program, {},
                        model::Error(model::codes::kUsage,
                                     is_option ? unknown_option(app, unknown.front()) : std::string(error.what())));
            return static_cast<int>(model::ExitCode::kUsage);
        } catch (const CLI::ParseError& error) {
            if (error.get_exit_code() == 0) {
                app.exit(error);  // --help, --version
                return 0;
            }
            print_error(program, {}, model::Error(model::codes::kUsage, error.what()));
            return static_cast<int>(model::ExitCode::kUsage);
        }
        return body(subject);
    } catch (const model::Error& error) {
        print_error(program, subject, error);
        return static_cast<int>(error.code().exit);
    } catch (const std::bad_alloc&) {
        print_error(program, subject, model::Error(model::codes::kInternal, "out of memory"));
    } catch (const std::exception& error) {
        print_error(program, subject, model::Error(model::codes::kInternal, error.what()));
    } catch (...) { std::fputs("internal error\n", stderr); }
    return static_cast<int>(model::ExitCode::kInternal);
}

}  // namespace dgm::tool
