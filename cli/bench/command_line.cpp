// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/command_line.cpp
#include "bench/command_line.h"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <thread>

#include "bench/bake_sweep.h"
#include "bench/compare.h"
#include "bench/interrupt.h"
#include "bench/machine_facts.h"
#include "bench/run_files.h"
#include "bench/run_sweep.h"
#include "bench/scale_sweep.h"
#include "bench/stability_sweep.h"
#include "dgm/atomic_file.h"
#include "pipeline/output_files.h"
#include "tool/tool.h"

namespace dgm::bench {
namespace {

namespace fs = std::filesystem;
namespace codes = model::codes;

constexpr double kBusy = 0.5;  ///< load a core beyond which times are not to be trusted

/// All but `uv`, which needs the mesh's own coordinates.
const std::vector<std::string> kAllMethods{"auto",  "stretch", "mvc",  "authalic", "conformal",
                                           "tutte", "lscm",    "arap", "slim"};

struct Common {
    fs::path output, compare;
    bool quiet = false;

    void add_to(CLI::App& app) {
        app.add_option(
            "-o,--output", output,
            "Folder for COMMAND.json, .html and a .csv for each table and the facts; made if need be [dgm-bench-out]");
        app.add_option("--compare", compare, "JSON file of an earlier run: what got faster, slower, better, worse");
        app.add_flag("-q,--quiet", quiet, "No progress, no results on the screen");
    }
};

std::string read_text(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    if (!in) throw model::Error(codes::kFileMissing, "it cannot be read", path.string());
    return {std::istreambuf_iterator<char>(in), {}};
}

void write_text(const fs::path& path, const std::string& text) {
    const fs::path temporary = bake::temporary_for(path);
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    out << text;
    out.close();
    if (!out) throw model::Error(codes::kWriteFailed, "it cannot be written", path.string());
    formats::publish_file(temporary, path);
}

void write_run(const Run& run, const fs::path& folder) {
    write_text(folder / (run.command + ".json"), to_json(run));
    write_text(folder / (run.command + ".html"), to_html(run));
    write_text(folder / (run.command + "-facts.csv"), facts_csv(run));
    for (const Table& table : run.tables)
        write_text(folder / (table.key == run.command ? table.key + ".csv" : run.command + "-" + table.key + ".csv"),
                   to_csv(table));
}

/// What the sweep found out, and where the rest is.
int finish(Run run, const Common& common, const std::optional<Run>& then) {
    if (then) run.comparison = compare_runs(run, *then);
    write_run(run, common.output);
    if (common.quiet) return static_cast<int>(model::ExitCode::kOk);
    std::string text;
    for (const std::string& line : run.findings) text += line + '\n';
    for (const std::string& line : run.comparison) text += line + '\n';
    text += fmt::format("written: {}\n", (common.output / (run.command + ".html")).string());
    std::fputs(text.c_str(), stdout);
    return static_cast<int>(model::ExitCode::kOk);
}

/// Finds out before minutes of measuring what would be found out after them.
std::optional<Run> prepare(Common& common, const std::string& command, const std::vector<fs::path>& assets) {
    for (const fs::path& asset : assets) {
        std::error_code ignored;
        if (!fs::is_regular_file(asset, ignored))
            throw model::Error(codes::kFileMissing, "there is no such file", asset.string());
    }
    std::optional<Run> then;
    if (!common.compare.empty()) {
        then = run_from_json(read_text(common.compare));
        Run wanted;
        wanted.command = command;
        (void)compare_runs(wanted, *then);
    }
    if (common.output.empty()) common.output = "dgm-bench-out";
    std::error_code error;
    fs::create_directories(common.output, error);
    if (error) throw model::Error(codes::kWriteFailed, error.message(), common.output.string());
    bake::check_writable(common.output / (command + ".json"));
    if (!common.quiet && load_per_core() > kBusy)
        std::fputs(fmt::format("dgm-bench: this machine is busy (load {:.1f} a core): times will spread; CPU times "
                               "less than wall times\n",
                               load_per_core())
                       .c_str(),
                   stderr);
    return then;
}

template <class Sweep>
int measure(Common& common, const std::string& command, const std::vector<fs::path>& assets, const Sweep& sweep) {
    const std::optional<Run> then = prepare(common, command, assets);
    return finish(sweep(), common, then);
}

void add_time_limit(CLI::App& app, double& seconds) {
    app.add_option("--time-limit", seconds, "Seconds that one bake may take")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
}

void add_side(CLI::App& app, std::uint32_t& side) {
    app.add_option("--size", side, "Samples a side of the meshes' maps")
        ->check(CLI::Range(bake::kMinSide, bake::kMaxSide))
        ->capture_default_str();
}

void add_repeats(CLI::App& app, BakeRepeats& repeats) {
    app.add_option(
           "--repeat", repeats.repetitions,
           "Times each bake is made; fewer than 3: no ratios. Grids above 300 a side: at most 3 times, above 600: once")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    app.add_option("-j,--jobs", repeats.jobs, "Bakes at a time [one a core]")->check(CLI::Range(1, 1024));
    add_time_limit(app, repeats.time_limit_seconds);
}

/// A subcommand: its options, and what it does.
struct BakeCommand {
    Common common;
    BakeSweepOptions sweep;
    CLI::App* app;

    explicit BakeCommand(CLI::App& parent) : app(parent.add_subcommand("bake", "Bake meshes with every choice")) {
        sweep.methods = kAllMethods;
        sweep.sizes = {33, 65, 129, 257, 513, 1025};
        sweep.precisions = {"f32", "u16"};
        sweep.fits = {"sample", "l2", "best"};
        sweep.layers = {"all", "geometry", "geometry+normal"};
        app->add_option("ASSET", sweep.assets, "Meshes to bake")->required();
        app->add_option("--methods", sweep.methods, "Methods, comma-separated")->delimiter(',')->capture_default_str();
        app->add_option("--sizes", sweep.sizes, "Samples a side")
            ->delimiter(',')
            ->check(CLI::Range(bake::kMinSide, bake::kMaxSide))
            ->capture_default_str();
        app->add_option("--compare-at", sweep.compared,
                        "Samples a side where methods, fits, precisions and layers are compared, one change at a time "
                        "[the second and the third of --sizes]: at all sizes they would take most of the time and say "
                        "little more")
            ->delimiter(',')
            ->check(CLI::Range(bake::kMinSide, bake::kMaxSide));
        app->add_option("--precisions", sweep.precisions, "f32, u16")->delimiter(',')->capture_default_str();
        app->add_option("--fits", sweep.fits, "sample, l2, best")->delimiter(',')->capture_default_str();
        app->add_option("--layers", sweep.layers, "Sets of layers: all, or names joined by +")
            ->delimiter(',')
            ->capture_default_str();
        app->add_flag("--full", sweep.full, "Every combination of these, instead of one change at a time");
        add_repeats(*app, sweep.repeats);
        common.add_to(*app);
    }
    int run() {
        std::sort(sweep.sizes.begin(), sweep.sizes.end());
        return measure(common, "bake", sweep.assets, [&] { return sweep_bakes(sweep, common.quiet); });
    }
};

struct RunCommand {
    Common common;
    RunSweepOptions sweep;
    CLI::App* app;

    explicit RunCommand(CLI::App& parent)
        : app(parent.add_subcommand("run", "Press, track and rebuild with every choice")) {
        app->add_option("ASSET", sweep.assets, "Meshes, which are baked first, or .dgm files")->required();
        app->add_option("--sizes", sweep.sizes, "Samples a side of the meshes' maps; 81, the paper's, is always there")
            ->delimiter(',')
            ->check(CLI::Range(bake::kMinSide, bake::kMaxSide))
            ->capture_default_str();
        app->add_option("--ticks", sweep.ticks, "Ticks of each setting")
            ->check(CLI::Range(1000, 100'000'000))
            ->capture_default_str();
        app->add_option("--path", sweep.path,
                        "Recorded tool positions, \"x y z\" a line in source units, a line a tick [3.3 s of a stomach "
                        "pressed, poked "
                        "and pulled, at the same places of each map]");
        common.add_to(*app);
    }
    int run() {
        return measure(common, "run", sweep.assets, [&] { return sweep_runtime(sweep, common.quiet); });
    }
};

struct StabilityCommand {
    Common common;
    StabilityOptions sweep;
    CLI::App* app;

    explicit StabilityCommand(CLI::App& parent)
        : app(parent.add_subcommand("stability", "Bake meshes that get harder and harder")) {
        sweep.methods = kAllMethods;
        sweep.families = family_names();
        app->add_option("--methods", sweep.methods, "Methods, comma-separated")->delimiter(',')->capture_default_str();
        app->add_option("--families", sweep.families, "Families of meshes")->delimiter(',')->capture_default_str();
        add_side(*app, sweep.side);
        app->add_option("-j,--jobs", sweep.jobs, "Bakes at a time [one a core]")->check(CLI::Range(1, 1024));
        add_time_limit(*app, sweep.time_limit_seconds);
        common.add_to(*app);
    }
    int run() {
        return measure(common, "stability", {}, [&] { return sweep_stability(sweep, common.quiet); });
    }
};

struct ScaleCommand {
    Common common;
    ScaleOptions sweep;
    CLI::App* app;

    explicit ScaleCommand(CLI::App& parent)
        : app(parent.add_subcommand("scale", "Bake larger and larger meshes, and more and more of them")) {
        app->add_option("--faces", sweep.faces, "Faces of the meshes")
            ->delimiter(',')
            ->check(CLI::Range(80, 20'000'000))
            ->capture_default_str();
        app->add_option("--assets", sweep.assets, "Meshes of the batches")
            ->delimiter(',')
            ->check(CLI::Range(1, 10'000))
            ->capture_default_str();
        app->add_option("--threads", sweep.threads, "Threads")
            ->delimiter(',')
            ->check(CLI::Range(1, 1024))
            ->capture_default_str();
        add_side(*app, sweep.side);
        add_time_limit(*app, sweep.time_limit_seconds);
        common.add_to(*app);
    }
    int run() {
        return measure(common, "scale", {}, [&] { return sweep_scale(sweep, common.quiet); });
    }
};

}  // namespace

int bench_program(int argc, char** argv) noexcept {
    CLI::App app("Measures speed against error on your own assets, and says what it advises.");
    app.require_subcommand(1);
    signal(SIGPIPE, SIG_IGN);
    listen_for_interrupts();
    BakeCommand bake_command(app);
    RunCommand run_command(app);
    StabilityCommand stability_command(app);
    ScaleCommand scale_command(app);
    const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
    bake_command.sweep.repeats.jobs = stability_command.sweep.jobs = cores;
    // run_tool catches what the body throws.
    // cppcheck-suppress throwInNoexceptFunction
    return tool::run_tool("dgm-bench", argc, argv, app, [&](std::string&) {
        if (bake_command.app->parsed()) return bake_command.run();
        if (stability_command.app->parsed()) return stability_command.run();
        if (scale_command.app->parsed()) return scale_command.run();
        return run_command.run();
    });
}

}  // namespace dgm::bench
