// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/command_line.cpp
#include "bench/command_line.h"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <cstdio>
#include <span>
#include <thread>

#include "bench/bake_sweep.h"
#include "bench/cloth_sweep.h"
#include "bench/compare.h"
#include "bench/interrupt.h"
#include "bench/machine_facts.h"
#include "bench/physics_sweep.h"
#include "bench/run_files.h"
#include "bench/run_sweep.h"
#include "bench/sample_asset.h"
#include "bench/scale_sweep.h"
#include "bench/stability_sweep.h"
#include "dgm/dgm_reader.h"
#include "files/nesting.h"
#include "files/output_file.h"
#include "files/regular_file.h"
#include "files/temporary_folder.h"
#include "model/file_errors.h"
#include "model/printable.h"
#include "tool/tool.h"

namespace dgm::bench {
namespace {

namespace fs = std::filesystem;
namespace codes = model::codes;

constexpr tool::Example kExamples[] = {
    {"dgm-bench bake stomach.obj -o out/", "methods, sizes, precision, fit and layers, one change at a time"},
    {"dgm-bench bake", "the same of a sample stomach"},
    {"dgm-bench bake stomach.obj --compare out/bake.json", "faster, slower, better, worse, beyond the noise"},
    {"dgm-bench run stomach.dgm", "ticks, tracking, contact, levels of detail"},
    {"dgm-bench physics liver.obj", "implicit steps: time against distance from the converged step"},
    {"dgm-bench cloth --sizes 65,257", "a hanging sheet: time of a frame against its distance from the closed form"},
    {"dgm-bench stability --families sliver,genus", "where methods start to fail, and what takes over"},
    {"dgm-bench scale --faces 10000,100000,1000000", "time and memory as meshes grow"},
};
constexpr tool::Term kFiles[] = {
    {"ASSET", "any mesh that dgm-bake reads; for run and physics also NAME.dgm"},
    {"FOLDER/COMMAND.json", "all that was measured, for --compare"},
    {"FOLDER/COMMAND.html", "one page with plots, fronts and tables; it needs no other file"},
    {"FOLDER/COMMAND*.csv", "each table, and the facts of the machine"}};
constexpr tool::Term kEnvironment[] = {{"TMPDIR", "folder for the maps that are baked to be measured [/tmp]"}};
constexpr tool::Manual kManual{.synopsis =
                                   "dgm-bench bake [OPTIONS] [ASSET...]\n"
                                   "dgm-bench run [OPTIONS] [ASSET...]\n"
                                   "dgm-bench physics [OPTIONS] [ASSET...]\n"
                                   "dgm-bench cloth [OPTIONS]\n"
                                   "dgm-bench stability [OPTIONS]\n"
                                   "dgm-bench scale [OPTIONS]",
                               .sections = {},
                               .examples = kExamples,
                               .files = kFiles,
                               .environment = kEnvironment,
                               .exit_codes =
                                   "0    measured; a mesh that is refused is a row that says why\n"
                                   "1    the command line is wrong\n"
                                   "2    a file cannot be read or written\n"
                                   "3    a mesh of run or physics is refused\n"
                                   "4    internal error, or a library crashed\n"
                                   "130  interrupted",
                               .see_also = "dgm-bake(1), dgm-info(1), dgm-validate(1), dgm-export(1), dgm-edit(1)"};

constexpr const char *kWhatIsMeasured = "What is measured", *kHowFine = "How fine";

constexpr double kBusy = 0.5;  ///< load a core beyond which times are not to be trusted

/// All but `uv`, which needs the mesh's own coordinates.
const std::vector<std::string> kAllMethods{"auto",  "stretch", "mvc",  "authalic", "conformal",
                                           "tutte", "lscm",    "arap", "slim"};

struct Common {
    fs::path output, compare;
    bool quiet = false;

    void add_to(CLI::App& app) {
        const tool::Group where(app, tool::kWhereThingsGo);
        where.value("-o,--output", "DIR", output, "folder for the results; made if need be [dgm-bench-out]");
        where.value("--compare", "FILE", compare, "JSON of an earlier run: what got faster, slower, better, worse");
        tool::Group(app, tool::kWhatItTells).flag("-q,--quiet", quiet, "no progress, no results on the screen");
    }
};

std::string read_text(const fs::path& path) {
    constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;
    std::string text = formats::read_small_file(path, kMostBytes);
    if (formats::too_deep_json(text, formats::kMostNesting))
        throw model::Error(codes::kReportUnreadable, "nested too deeply", path.string());
    return text;
}

void write_run(const Run& run, const fs::path& folder) {
    formats::write_output(folder / (run.command + ".json"), to_json(run));
    formats::write_output(folder / (run.command + ".html"), to_html(run));
    formats::write_output(folder / (run.command + "-facts.csv"), facts_csv(run));
    for (const Table& table : run.tables)
        formats::write_output(
            folder / (table.key == run.command ? table.key + ".csv" : run.command + "-" + table.key + ".csv"),
            to_csv(table));
}

/// Prints the findings of the sweep and the place of its files.
int finish(Run run, const Common& common, const std::optional<Run>& then) {
    if (then) run.comparison = compare_runs(run, *then);
    write_run(run, common.output);
    if (common.quiet) return static_cast<int>(model::ExitCode::kOk);
    std::string text;
    for (const std::string& line : run.findings) text += line + '\n';
    for (const std::string& line : run.comparison) text += line + '\n';
    text += fmt::format("written: {}\n", (common.output / (run.command + ".html")).string());
    std::fputs(model::printable_lines(text).c_str(), stdout);
    return static_cast<int>(model::ExitCode::kOk);
}

/// Says what is wrong with a damaged map. @throws model::Error with the file as its place
void check_map(const fs::path& file) {
    try {
        (void)formats::read_dgm(file);
    } catch (const model::Error& error) {
        const bool is_inside = error.place().starts_with('/') && error.place() != file.string();
        throw model::Error(error.code(), error.what() + (is_inside ? " (" + error.place() + ")" : ""), file.string());
    }
}

/// Finds out before minutes of measuring what would be found out after them.
std::optional<Run> prepare(Common& common, const std::string& command, const std::vector<fs::path>& assets) {
    for (const fs::path& asset : assets) {
        std::error_code ignored;
        if (!fs::exists(asset, ignored)) throw model::missing_file(asset);
        if (!fs::is_regular_file(asset, ignored)) throw model::no_regular_file(asset);
        if (asset.extension() == ".dgm") check_map(asset);
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
    if (error) throw model::unwritable_folder(common.output, error.message());
    const fs::path results = common.output / (command + ".json");
    formats::refuse_input_as_output(results, std::span(&common.compare, 1), "results");
    formats::check_output(results);
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

/// The same for a sweep of assets: those that are named, else the sample, which lasts as long as the sweep.
template <class Sweep>
int measure_assets(Common& common, const std::string& command, std::vector<fs::path>& assets, const Sweep& sweep) {
    return measure(common, command, assets, [&] {
        std::optional<formats::TemporaryFolder> folder;
        const bool none_named = assets.empty();
        if (none_named) assets = {make_sample_asset(folder.emplace("dgm-bench").path())};
        Run run = sweep();
        if (none_named) run.settings.emplace_back("asset", "the sample stomach of dgm-make-samples");
        return run;
    });
}

void add_assets(CLI::App& app, std::vector<fs::path>& assets, const std::string& what) {
    app.add_option("ASSET", assets, what + " [a stomach of 11 540 triangles, which is made on the spot]")
        ->type_name("");
}

/// A list of words.
void add_words(CLI::App& app, const char* name, const char* type, std::vector<std::string>& words, const char* what) {
    tool::Group(app, kWhatIsMeasured).value(name, type, words, what)->delimiter(',')->capture_default_str();
}

void add_methods(CLI::App& app, std::vector<std::string>& methods) {
    methods = kAllMethods;
    add_words(app, "--methods", "M,...", methods, "methods");
}

CLI::Option* add_sides(CLI::App& app, const char* name, std::vector<std::uint32_t>& sides, const char* what) {
    return tool::Group(app, kHowFine)
        .value(name, "N,...", sides, what)
        ->delimiter(',')
        ->check(CLI::Range(bake::kMinSide, bake::kMaxSide));
}

/// A list of numbers from 1, or from `least`, to `most`.
template <class Number>
void add_counts(CLI::App& app, const char* name, std::vector<Number>& counts, const char* what, int most,
                int least = 1) {
    tool::Group(app, kWhatIsMeasured)
        .value(name, "N,...", counts, what)
        ->delimiter(',')
        ->check(CLI::Range(least, most))
        ->capture_default_str();
}

void add_jobs(CLI::App& app, unsigned& jobs) {
    jobs = std::max(1U, std::thread::hardware_concurrency());
    tool::Group(app, tool::kHowItRuns)
        .number("-j,--jobs", "N", jobs, "bakes at a time [one a core]")
        ->check(CLI::Range(1, 1024));
}

void add_time_limit(CLI::App& app, double& seconds) {
    tool::Group(app, tool::kHowItRuns)
        .number("--time-limit", "S", seconds, "seconds that one bake may take")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
}

void add_side(CLI::App& app, std::uint32_t& side) {
    tool::Group(app, kHowFine)
        .number("--size", "N", side, "samples a side of the meshes' maps")
        ->check(CLI::Range(bake::kMinSide, bake::kMaxSide))
        ->capture_default_str();
}

void add_repeats(CLI::App& app, BakeRepeats& repeats) {
    tool::Group(app, tool::kHowItRuns)
        .number("--repeat", "N", repeats.repetitions,
                "times that each bake is made; fewer than 3: no ratios. Grids above 300 a side: at most 3 times, above "
                "600: "
                "once")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    add_jobs(app, repeats.jobs);
    add_time_limit(app, repeats.time_limit_seconds);
}

/// A subcommand: its options, and its action.
struct BakeCommand {
    Common common;
    BakeSweepOptions sweep;
    CLI::App* app;

    explicit BakeCommand(CLI::App& parent) : app(parent.add_subcommand("bake", "bake meshes with every choice")) {
        sweep.sizes = {33, 65, 129, 257, 513, 1025};
        sweep.precisions = {"f32", "u16"};
        sweep.fits = {"sample", "l2", "best"};
        sweep.layers = {"all", "geometry", "geometry+normal"};
        add_assets(*app, sweep.assets, "meshes to bake");
        add_methods(*app, sweep.methods);
        add_sides(*app, "--sizes", sweep.sizes, "samples a side")->capture_default_str();
        add_sides(
            *app, "--compare-at", sweep.compared,
            "samples a side where methods, fits, precisions and layers are compared, one change at a time; at all "
            "sizes they would take most of the time and say little more [the second and the third of --sizes]");
        add_words(*app, "--precisions", "P,...", sweep.precisions, "precisions of positions");
        add_words(*app, "--fits", "F,...", sweep.fits, "fits");
        add_words(*app, "--layers", "SET,...", sweep.layers, "sets of layers: all, or names joined by +");
        tool::Group(*app, kWhatIsMeasured)
            .flag("--full", sweep.full, "every combination of these, instead of one change at a time");
        add_repeats(*app, sweep.repeats);
        common.add_to(*app);
    }
    int run() {
        std::sort(sweep.sizes.begin(), sweep.sizes.end());
        return measure_assets(common, "bake", sweep.assets, [&] { return sweep_bakes(sweep, common.quiet); });
    }
};

struct RunCommand {
    Common common;
    RunSweepOptions sweep;
    CLI::App* app;

    explicit RunCommand(CLI::App& parent)
        : app(parent.add_subcommand("run", "press, track and rebuild with every choice")) {
        add_assets(*app, sweep.assets, "meshes, which are baked first, or .dgm files");
        add_sides(*app, "--sizes", sweep.sizes, "samples a side of the meshes' maps; 81, the paper's, is always there")
            ->capture_default_str();
        const tool::Group measured(*app, kWhatIsMeasured);
        measured.number("--ticks", "N", sweep.ticks, "ticks of each setting")
            ->check(CLI::Range(1000, 100'000'000))
            ->capture_default_str();
        measured.value(
            "--path", "FILE", sweep.path,
            "recorded tool positions, \"x y z\" a line in source units, a line a tick; or a path that a page "
            "saved [3.3 s of a stomach pressed, poked and pulled, at the same places of each map]");
        common.add_to(*app);
    }
    int run() {
        return measure_assets(common, "run", sweep.assets, [&] { return sweep_runtime(sweep, common.quiet); });
    }
};

struct PhysicsCommand {
    Common common;
    PhysicsSweepOptions sweep;
    CLI::App* app;

    explicit PhysicsCommand(CLI::App& parent)
        : app(parent.add_subcommand("physics", "solve steps of mass and material with every choice")) {
        add_assets(*app, sweep.assets, "meshes, which are baked first, or .dgm files");
        add_sides(*app, "--sizes", sweep.sizes, "samples a side of the meshes' maps")->capture_default_str();
        add_counts(*app, "--cycles", sweep.cycles, "iterations of the solver in a step", 1000);
        add_words(*app, "--solvers", "S,...", sweep.solvers, "preconditioners: multigrid, factors");
        const tool::Group measured(*app, kWhatIsMeasured);
        measured.value("--milliseconds", "T,...", sweep.milliseconds, "lengths of a step")
            ->delimiter(',')
            ->check(CLI::Range(0.01, 10'000.0))
            ->capture_default_str();
        measured.value("--strides", "K,...", sweep.strides, "also steps of every K-th sample, shown on all of them")
            ->delimiter(',')
            ->check(CLI::Range(1, 64));
        measured.number("--steps", "N", sweep.steps, "steps that are timed, of each setting")
            ->check(CLI::Range(100, 1'000'000))
            ->capture_default_str();
        measured
            .number("--metres-per-unit", "M", sweep.metres_per_unit,
                    "length of a unit of the assets [so that each has a diagonal of 0.15 m]")
            ->check(CLI::Range(1e-9, 1e9));
        common.add_to(*app);
    }
    int run() {
        return measure_assets(common, "physics", sweep.assets, [&] { return sweep_physics(sweep, common.quiet); });
    }
};

struct ClothCommand {
    Common common;
    ClothSweepOptions sweep;
    CLI::App* app;

    explicit ClothCommand(CLI::App& parent) : app(parent.add_subcommand("cloth", "hang a sheet with every choice")) {
        add_sides(*app, "--sizes", sweep.sizes, "samples a side of the sheet's maps")->capture_default_str();
        add_counts(*app, "--substeps", sweep.substeps, "implicit steps in a frame", 100);
        add_counts(*app, "--cycles", sweep.cycles, "iterations of the solver in a substep", 100);
        const tool::Group measured(*app, kWhatIsMeasured);
        measured.value("--levels", "K,...", sweep.levels, "strides that the solver uses; 0: all")
            ->delimiter(',')
            ->check(CLI::Range(0, 16))
            ->capture_default_str();
        measured.number("--modulus", "E", sweep.modulus, "of warp and weft, N/m")
            ->check(CLI::Range(1.0, 1e6))
            ->capture_default_str();
        measured.number("--frames", "N", sweep.frames, "frames of 1/60 s, of each setting")
            ->check(CLI::Range(100, 1'000'000))
            ->capture_default_str();
        common.add_to(*app);
    }
    int run() {
        return measure(common, "cloth", {}, [&] { return sweep_cloth(sweep, common.quiet); });
    }
};

struct StabilityCommand {
    Common common;
    StabilityOptions sweep;
    CLI::App* app;

    explicit StabilityCommand(CLI::App& parent)
        : app(parent.add_subcommand("stability", "bake meshes that get harder and harder")) {
        sweep.families = family_names();
        add_methods(*app, sweep.methods);
        add_words(*app, "--families", "NAME,...", sweep.families, "families of meshes");
        add_side(*app, sweep.side);
        add_jobs(*app, sweep.jobs);
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
        : app(parent.add_subcommand("scale", "bake larger and larger meshes, and more and more of them")) {
        add_counts(*app, "--faces", sweep.faces, "faces of the meshes", 20'000'000, 80);
        add_counts(*app, "--assets", sweep.assets, "meshes of the batches", 10'000);
        add_counts(*app, "--threads", sweep.threads, "threads", 1024);
        add_side(*app, sweep.side);
        add_time_limit(*app, sweep.time_limit_seconds);
        common.add_to(*app);
    }
    int run() {
        return measure(common, "scale", {}, [&] { return sweep_scale(sweep, common.quiet); });
    }
};

}  // namespace

int bench_program(int argc, char** argv) {
    CLI::App app("Measures speed against error on your own assets, and says what it advises.");
    app.require_subcommand(1);
    signal(SIGPIPE, SIG_IGN);
    listen_for_interrupts();
    BakeCommand bake_command(app);
    RunCommand run_command(app);
    PhysicsCommand physics_command(app);
    ClothCommand cloth_command(app);
    StabilityCommand stability_command(app);
    ScaleCommand scale_command(app);
    return tool::run_tool("dgm-bench", argc, argv, app, kManual, [&](std::string&) {
        if (bake_command.app->parsed()) return bake_command.run();
        if (physics_command.app->parsed()) return physics_command.run();
        if (cloth_command.app->parsed()) return cloth_command.run();
        if (stability_command.app->parsed()) return stability_command.run();
        if (scale_command.app->parsed()) return scale_command.run();
        return run_command.run();
    });
}

}  // namespace dgm::bench
