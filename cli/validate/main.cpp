// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/main.cpp
// dgm-validate: checks that a file keeps its format, and is as near to its source as it claims.
#include <malloc.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "files/atomic_file.h"
#include "files/output_file.h"
#include "model/codes.h"
#include "model/file_errors.h"
#include "process/mesh_import.h"
#include "tool/guarded_main.h"
#include "tool/tool.h"
#include "validate/code_pages.h"
#include "validate/file_list.h"
#include "validate/output.h"
#include "validate/run.h"

namespace dgm::validate {
namespace {
using model::ExitCode;

struct CommandLine {
    std::vector<std::string> files, severities, reports, asset_roots;
    std::string source, format = "text", explain, max_rms, max_hausdorff, baseline, write_baseline;
    std::size_t max_issues = std::numeric_limits<std::size_t>::max();
    unsigned jobs = 0;
    double time_limit = 600;
    std::uint64_t memory_limit = std::uint64_t{8} << 30;
    bool quiet = false, verbose = false;
};

constexpr std::array kExamples{
    tool::Example{"dgm-validate stomach.dgm", "is the file whole, and are its values sound?"},
    tool::Example{"dgm-validate stomach.dgm --source stomach.obj", "is it as near to the mesh as it claims?"},
    tool::Example{"dgm-validate baked/*.dgm -q", "errors only; the exit code tells the rest"},
    tool::Example{"dgm-validate --explain DGM1003", "what a code means, and what to do"}};
constexpr std::array kFiles{
    tool::Term{"NAME.dgm, NAME.exr", "a map that is checked"},
    tool::Term{"the files of --report", "JSON as docs/schemas/validate.schema.json says, JUnit XML, or SARIF 2.1.0"},
    tool::Term{"the file of --write-baseline", "JSON with the findings of today, for --baseline"}};
const tool::Manual kManual{.synopsis = "dgm-validate [OPTIONS] FILE...\ndgm-validate --explain CODE",
                           .sections = {},
                           .examples = kExamples,
                           .files = kFiles,
                           .environment = {},
                           .exit_codes =
                               "0    all files are valid\n"
                               "1    the command line is wrong\n"
                               "2    a file cannot be read or written\n"
                               "3    a file is not valid\n"
                               "4    internal error, or a library crashed\n"
                               "5    a file is of a newer version\n"
                               "With several files, that of the worst.",
                           .see_also = "dgm-bake(1), dgm-info(1), dgm-export(1), dgm-edit(1), dgm-bench(1)"};

/// "0.05%" or "0.05" to 0.05, whatever the locale.
std::optional<double> parse_percent(std::string_view text) {
    if (text.ends_with('%')) text.remove_suffix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || !(value >= 0) || value > 1e9) return std::nullopt;
    return value;
}

void declare_checks(CLI::App& app, CommandLine& line) {
    const CLI::Validator percent(
        [](const std::string& text) {
            return parse_percent(text) ? std::string() : "`" + text + "` is not a percentage such as 0.05%";
        },
        "");
    const tool::Group source(app, "Against the source"), judged(app, "What counts");
    source.text("--source", "MESH", line.source,
                "mesh to measure the reconstruction against, or a folder that holds the meshes of all files");
    source.value("--asset-root", "DIR", line.asset_roots,
                 "folder beside the mesh's from which it may name files, as for dgm-bake; repeatable");
    source
        .text("--max-rms", "X%", line.max_rms,
              "largest rms distance, in % of the source's bounding-box diagonal [what the file's report claims, plus 1 "
              "%]")
        ->check(percent)
        ->needs("--source");
    source
        .text("--max-hausdorff", "X%", line.max_hausdorff,
              "largest distance of all, likewise [what the file's report claims, plus 5 %]")
        ->check(percent)
        ->needs("--source");
    judged.value("--severity", "CODE=LEVEL", line.severities,
                 "another severity, such as DGM2015=off: error, warning, note, off; repeatable");
    CLI::Option* baseline =
        judged.text("--baseline", "FILE", line.baseline, "findings that this file lists pass, new ones fail");
    judged.text("--write-baseline", "FILE", line.write_baseline, "list what was found in this file, and pass")
        ->excludes(baseline);
}

void declare(CLI::App& app, CommandLine& line) {
    app.description(
        "Checks .dgm files, and EXR files of geometry maps: structure, hashes, layers, seams, topology, report, and "
        "the "
        "distance to a source mesh.");
    app.add_option("FILE", line.files, "files, folders, or patterns such as 'baked/**/*.dgm'")->type_name("");
    const tool::Group where(app, tool::kWhereThingsGo);
    where.text("--format", "text|json|junit|sarif|markdown", line.format, "of stdout; markdown for --explain [text]")
        ->check(CLI::IsMember({"text", "json", "junit", "sarif", "markdown"}));
    where.value("--report", "FORMAT=FILE", line.reports,
                "write a report to a file as well, such as junit=validate.xml; repeatable");
    declare_checks(app, line);
    const tool::Group runs(app, tool::kHowItRuns);
    runs.number("-j,--jobs", "N", line.jobs, "files at a time [one a core]")->check(CLI::Range(1, 1024));
    runs.number("--time-limit", "SECONDS", line.time_limit, "wall time of one file [600]")->check(CLI::Range(0.1, 1e7));
    runs.number("--memory-limit", "SIZE", line.memory_limit,
                "memory that one file may take, such as 8GiB; 0: no limit; its layers may take a quarter [8GiB]")
        ->transform(CLI::AsSizeValue(false));
    const tool::Group tells(app, tool::kWhatItTells);
    tells
        .number("--max-issues", "N", line.max_issues,
                "findings listed of each file, errors first; all are counted, and decide the exit code [all]")
        ->check(CLI::Range(0, 1 << 30));
    tells.text("--explain", "CODE", line.explain,
               "print what a code such as DGM1003 means, why it matters and what to do, and stop; or all");
    CLI::Option* quiet = tells.flag("-q,--quiet", line.quiet, "errors only");
    tells.flag("-v,--verbose", line.verbose, "what was measured, and known findings, too")->excludes(quiet);
}

/// Writes to stdout; a full disk is an error like any other. @throws model::Error kWriteFailed
void put(const std::string& text) {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
        throw model::Error(model::codes::kWriteFailed, "the output cannot be written", "stdout");
}

void print_explanation(const CommandLine& line) {
    const bool all = line.explain == "all";
    const model::Code* code = find_code(line.explain);
    if (!all && code == nullptr) throw model::Error(model::codes::kUsage, "there is no code `" + line.explain + "`");
    if (line.format == "markdown") {
        if (!all) throw model::Error(model::codes::kUsage, "--format markdown goes with --explain all");
        put(codes_markdown());
    } else {
        put(all ? explain_all() : explain(*code));
    }
}

std::string report_text(const std::string& format, const std::vector<FileValidation>& files,
                        const OutputOptions& options) {
    if (format == "json") return to_json(files, options);
    if (format == "junit") return to_junit(files, options);
    if (format == "sarif") return to_sarif(files, options);
    std::string text;
    for (const FileValidation& file : files) text += to_text(file, options);
    return text + summary_text(files, options);
}

struct Report {
    std::string format, file;
};
Report parse_report(const std::string& text) {
    const std::size_t equals = text.find('=');
    Report report{text.substr(0, equals), equals == std::string::npos ? std::string() : text.substr(equals + 1)};
    const bool known =
        report.format == "text" || report.format == "json" || report.format == "junit" || report.format == "sarif";
    if (!known || report.file.empty())
        throw model::Error(model::codes::kUsage, "--report: `" + text + "` is not FORMAT=FILE, such as junit=out.xml");
    return report;
}

/// Before minutes of checks: whether every report can be put in place, and overwrites nothing that is read.
void check_outputs(const CommandLine& line, const std::vector<Report>& reports,
                   const std::vector<std::filesystem::path>& files) {
    std::vector<std::filesystem::path> inputs = files;
    for (const std::string& input : {line.source, line.baseline}) inputs.emplace_back(input);
    const auto check = [&](const std::string& file, std::string_view what) {
        formats::refuse_input_as_output(file, inputs, what);
        formats::make_folder_of(file);
        formats::check_output(file);
    };
    for (const Report& report : reports) check(report.file, "report");
    if (!line.write_baseline.empty()) check(line.write_baseline, "baseline");
}

/// Memory of one file serves the next: by default each large block is mapped, filled with zeros page by page and
/// released, which takes as long as the checks.
void keep_memory() {
#ifdef __GLIBC__
    constexpr int kMany = 1 << 30;
    mallopt(M_MMAP_THRESHOLD, kMany);
    mallopt(M_TRIM_THRESHOLD, kMany);
#endif
}

ExitCode run(const CommandLine& line, std::string& subject) {
    if (!line.explain.empty()) {
        print_explanation(line);
        return ExitCode::kOk;
    }
    if (line.files.empty()) throw model::Error(model::codes::kUsage, tool::missing_argument("FILE", kManual));
    if (line.format == "markdown")
        throw model::Error(model::codes::kUsage, "--format markdown goes with --explain all");

    RunOptions options;
    options.files = expand_names(line.files);
    options.source = line.source;
    bake::ImportLimits limits;
    limits.asset_roots.assign(line.asset_roots.begin(), line.asset_roots.end());
    options.read_mesh = [limits](const std::filesystem::path& path) { return bake::import_apart(path, limits).mesh; };
    if (!line.max_rms.empty()) options.max_rms_percent = parse_percent(line.max_rms);
    if (!line.max_hausdorff.empty()) options.max_hausdorff_percent = parse_percent(line.max_hausdorff);
    for (const std::string& rule : line.severities) add_severity_rule(options.severities, rule);
    if (!line.baseline.empty()) {
        subject = line.baseline;
        options.baseline = Baseline::read(line.baseline);
        subject.clear();
    }
    keep_memory();
    options.jobs = line.jobs > 0 ? line.jobs : std::max(1u, std::thread::hardware_concurrency());
    const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
    options.limits =
        FileLimits{line.time_limit, line.memory_limit, std::max(1u, cores / std::min(cores, options.jobs))};
    std::vector<Report> reports;
    for (const std::string& text : line.reports) reports.push_back(parse_report(text));
    check_outputs(line, reports, options.files);

    OutputOptions output;
    output.verbosity = line.quiet ? Verbosity::kQuiet : line.verbose ? Verbosity::kVerbose : Verbosity::kNormal;
    output.max_issues = line.max_issues;
    output.version = tool::kVersion;
    output.homepage = tool::kHomepage;
    output.has_source = !line.source.empty();
    output.has_baseline = !line.baseline.empty();
    const bool text = line.format == "text";
    const std::vector<FileValidation> files = run_validation(options, [&](const FileValidation& file) {
        if (text) put(to_text(file, output));
    });
    put(text ? summary_text(files, output) : report_text(line.format, files, output));
    for (const Report& report : reports) formats::write_output(report.file, report_text(report.format, files, output));
    if (line.write_baseline.empty()) return worst_exit(files);
    formats::write_output(line.write_baseline, baseline_json(files, line.write_baseline));
    return ExitCode::kOk;
}
}  // namespace
}  // namespace dgm::validate

static int run_main(int argc, char** argv) {
    if (const auto exit_code = dgm::bake::import_worker(argc, argv)) return *exit_code;
    dgm::validate::CommandLine line;
    CLI::App app;
    dgm::validate::declare(app, line);
    return dgm::tool::run_tool("dgm-validate", argc, argv, app, dgm::validate::kManual, [&](std::string& subject) {
        return static_cast<int>(dgm::validate::run(line, subject));
    });
}

int main(int argc, char** argv) {
    return dgm::tool::guarded_main("dgm-validate", [&] { return run_main(argc, argv); });
}
