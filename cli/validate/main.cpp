// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/main.cpp
// dgm-validate: is this file what it says it is, and as near to its source as it claims?
#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "model/codes.h"
#include "tool/tool.h"
#include "validate/output.h"
#include "validate/validation.h"

namespace dgm::validate {
namespace {
using model::ExitCode;

struct CommandLine {
    std::vector<std::string> files;
    std::string source, format = "text", explain, max_rms, max_hausdorff;
    bool quiet = false, verbose = false;
};

constexpr std::array kExamples{
    tool::Example{"dgm-validate stomach.dgm", "is the file whole, and are its values sound?"},
    tool::Example{"dgm-validate stomach.dgm --source stomach.obj", "is it as near to the mesh as it claims?"},
    tool::Example{"dgm-validate baked/*.dgm -q", "errors only; the exit code tells the rest"},
    tool::Example{"dgm-validate --explain DGM1003", "what a code means, and what to do"}};
const tool::Manual kManual{"dgm-validate [OPTIONS] FILE...\ndgm-validate --explain CODE", kExamples,
                           "0    all files are valid\n"
                           "1    the command line is wrong\n"
                           "2    a file cannot be read\n"
                           "3    a file is not valid\n"
                           "4    internal error\n"
                           "5    a file is of a newer version\n"
                           "With several files, that of the worst.",
                           "dgm-bake(1), dgm-info(1), dgm-export(1)"};

/// "0.05%" or "0.05" to 0.05, whatever the locale.
std::optional<double> parse_percent(std::string_view text) {
    if (text.ends_with('%')) text.remove_suffix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || !(value >= 0) || value > 1e9) return std::nullopt;
    return value;
}

void declare(CLI::App& app, CommandLine& line) {
    const CLI::Validator percent(
        [](const std::string& text) {
            return parse_percent(text) ? std::string() : "`" + text + "` is not a percentage such as 0.05%";
        },
        "X%");
    app.description(
        "Checks .dgm files: structure, hashes, layers, seams, topology, and the distance to a source mesh.");
    app.add_option("FILE", line.files, "Files to check");
    app.add_option("--source", line.source, "Mesh to measure the reconstruction against")->type_name("MESH");
    app.add_option("--max-rms", line.max_rms,
                   "Largest rms distance, in % of the source's bounding-box diagonal "
                   "(default: what the file's report claims)")
        ->check(percent)
        ->needs("--source");
    app.add_option("--max-hausdorff", line.max_hausdorff, "Largest distance of all, likewise")
        ->check(percent)
        ->needs("--source");
    app.add_option("--format", line.format, "text or json")
        ->check(CLI::IsMember({"text", "json"}))
        ->type_name("FORMAT");
    app.add_option("--explain", line.explain, "Print what a code such as DGM1003 means, and stop")->type_name("CODE");
    auto* quiet = app.add_flag("-q,--quiet", line.quiet, "Print errors only");
    app.add_flag("-v,--verbose", line.verbose, "Print what was measured, too")->excludes(quiet);
}

/// Writes to stdout; a full disk is an error like any other. @throws model::Error kWriteFailed
void put(const std::string& text) {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
        throw model::Error(model::codes::kWriteFailed, "the output cannot be written", "stdout");
}

ExitCode run(const CommandLine& line, std::string& subject) {
    if (!line.explain.empty()) {
        const model::Code* code = find_code(line.explain);
        if (code == nullptr) throw model::Error(model::codes::kUsage, "there is no code `" + line.explain + "`");
        put(explain(*code));
        return ExitCode::kOk;
    }
    if (line.files.empty()) throw model::Error(model::codes::kUsage, "no FILE was named");

    Options options;
    std::optional<Source> source;
    if (!line.source.empty()) {
        subject = line.source;
        source = load_source(line.source);
        options.source = &*source;
        if (!line.max_rms.empty()) options.max_rms_percent = parse_percent(line.max_rms);
        if (!line.max_hausdorff.empty()) options.max_hausdorff_percent = parse_percent(line.max_hausdorff);
    }
    const Verbosity verbosity = line.quiet     ? Verbosity::kQuiet
                                : line.verbose ? Verbosity::kVerbose
                                               : Verbosity::kNormal;
    ExitCode worst = ExitCode::kOk;
    std::vector<FileValidation> results;
    for (const std::string& file : line.files) {
        subject = file;
        FileValidation result = validate_file(file, options);
        worst = dgm::model::worse(worst, result.exit_code());
        if (line.format == "json")
            results.push_back(std::move(result));
        else
            put(to_text(result, verbosity));
    }
    if (line.format == "json") put(to_json(results));
    return worst;
}
}  // namespace
}  // namespace dgm::validate

int main(int argc, char** argv) {
    dgm::validate::CommandLine line;
    CLI::App app;
    dgm::validate::declare(app, line);
    return dgm::tool::run_tool("dgm-validate", argc, argv, app, dgm::validate::kManual, [&](std::string& subject) {
        return static_cast<int>(dgm::validate::run(line, subject));
    });
}
