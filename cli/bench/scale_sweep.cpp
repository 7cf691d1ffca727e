// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/scale_sweep.cpp
#include "bench/scale_sweep.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bench/columns.h"
#include "bench/hard_meshes.h"
#include "bench/machine_facts.h"
#include "bench/progress_bar.h"
#include "bench/repeat.h"
#include "bench/result_figures.h"
#include "files/temporary_folder.h"
#include "mesh/mesh_writer.h"
#include "model/codes.h"

namespace dgm::bench {
namespace {

namespace fs = std::filesystem;
using bake::AssetResult;

constexpr unsigned kRepetitions = 3;

Table face_table() {
    Table t;
    t.key = "faces";
    t.title = "Larger meshes";
    t.note = "Closed bumpy balls, baked with the defaults of dgm-bake, one at a time. Map: cut and parameterization.";
    t.columns = joined(
        {{key_column("threads", "threads"), exact_column("faces", "faces", "", Sense::kNone),
          key_column("mesh", "mesh"), text_column("outcome", "outcome")},
         bake_columns(),
         {time_column("map_seconds", "map CPU", "s"), exact_column("rms_percent", "rms", "%", Sense::kLower, 0.01)}});
    t.plots = {{"Time against faces", "faces", "wall_seconds", "threads", "", true},
               {"CPU time against faces", "faces", "cpu_seconds", "threads", "", true},
               {"Memory against faces", "faces", "memory_mib", "threads", "", true}};
    return t;
}

Table asset_table() {
    Table t;
    t.key = "assets";
    t.title = "More meshes";
    t.note = "Batches of equal balls, as many bakes at a time as there are threads, one thread each.";
    t.columns = {key_column("threads", "threads"),
                 exact_column("assets", "assets", "", Sense::kNone),
                 key_column("batch", "batch"),
                 text_column("outcome", "outcome"),
                 time_column("wall_seconds", "wall", "s"),
                 time_column("cpu_seconds", "CPU of all", "s"),
                 time_column("memory_mib", "largest peak memory", "MiB")};
    t.plots = {{"Time against assets", "assets", "wall_seconds", "threads", "", true}};
    return t;
}

Figure once(double value) {
    return {value, value, value, 1, false};
}

void add_mesh_rows(Table& table, const ScaleOptions& options, const fs::path& folder, ProgressBar& bar) {
    bake::BakeOptions bake_options;
    bake_options.size = {options.side, options.side};
    for (const std::uint64_t faces : options.faces) {
        const fs::path mesh = folder / "ball.obj";
        formats::write_obj(mesh, bumpy_ball(faces));
        for (const unsigned threads : options.threads) {
            BakeRepeats repeats;
            repeats.repetitions = faces <= options.repeated_faces ? kRepetitions : 1;
            repeats.threads = threads;
            repeats.time_limit_seconds = options.time_limit_seconds;
            repeats.memory_bytes = 0;
            bar.begin(fmt::format("{} faces, {} threads", faces, threads),
                      static_cast<double>(faces) * repeats.repetitions);
            const std::vector<AssetResult> results =
                bake_repeatedly({mesh}, bake_options, repeats, folder, [&](double s) { bar.update(s); });
            RowBuilder row(table);
            row.set("threads", std::to_string(threads));
            row.set("faces", exactly(static_cast<double>(faces)));
            row.set("mesh", std::to_string(faces));
            const AssetResult& first = results.front();
            row.set("outcome", first.error ? error_name(*first.error) : methods_of(first));
            if (first.outcome == bake::Outcome::kBaked) {
                set_bake(row, results);
                row.set("map_seconds",
                        figure_of(results, [](const AssetResult& r) { return stage_seconds(r, "map"); }));
                row.set("rms_percent", exactly(100 * first.report.error.rms / first.report.error.diagonal));
            }
            table.rows.push_back(row.row());
        }
    }
}

void add_batch_rows(Table& table, const ScaleOptions& options, const fs::path& folder, ProgressBar& bar) {
    bake::BakeOptions bake_options;
    bake_options.size = {65, 65};
    const fs::path mesh = folder / "ball.obj";
    formats::write_obj(mesh, bumpy_ball(options.faces_of_assets));
    for (const unsigned count : options.assets)
        for (const unsigned threads : options.threads) {
            BakeRepeats batch;
            batch.repetitions = count;
            batch.jobs = threads;
            batch.time_limit_seconds = options.time_limit_seconds;
            bar.begin(fmt::format("{} assets, {} threads", count, threads),
                      static_cast<double>(count * options.faces_of_assets));
            const auto start = std::chrono::steady_clock::now();
            const std::vector<AssetResult> results =
                bake_repeatedly({mesh}, bake_options, batch, folder, [&](double s) { bar.update(s); });
            const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            double cpu = 0, memory = 0;
            std::size_t baked = 0;
            std::string outcome;  // of the first that failed
            for (const AssetResult& r : results) {
                baked += r.outcome == bake::Outcome::kBaked ? 1 : 0;
                if (r.error && outcome.empty()) outcome = error_name(*r.error);
                cpu += r.report.cpu_seconds;
                memory = std::max(memory, peak_mib(r));
            }
            RowBuilder row(table);
            row.set("threads", std::to_string(threads));
            row.set("assets", exactly(count));
            row.set("batch", fmt::format("{} x {} faces at 65x65", count, options.faces_of_assets));
            row.set("outcome", outcome.empty() ? fmt::format("{} baked", baked)
                                               : fmt::format("{} of {} baked, {}", baked, count, outcome));
            row.set("wall_seconds", once(wall));
            row.set("cpu_seconds", once(cpu));
            row.set("memory_mib", once(memory));
            table.rows.push_back(row.row());
        }
}

/// "CPU time grows like faces^1.07 +- 0.03 (1 thread)" for each number of threads.
void add_exponents(const Table& table, const char* x, const char* y, const char* what, std::vector<std::string>& out) {
    for (const std::string& threads : values_of(table, "threads")) {
        std::vector<double> xs, ys;
        for (std::size_t row = 0; row < table.rows.size(); ++row)
            if (table.text(row, "threads") == threads && std::isfinite(table.number(row, y))) {
                xs.push_back(table.number(row, x));
                ys.push_back(table.number(row, y));
            }
        if (const auto law = fit_power_law(xs, ys))
            out.push_back(fmt::format("{} grows like {}^({:.2f} +- {:.2f}) on {} thread{}", what, x, law->exponent,
                                      2 * law->error, threads, threads == "1" ? "" : "s"));
    }
}

}  // namespace

Run sweep_scale(const ScaleOptions& options, bool quiet) {
    Run run;
    run.command = "scale";
    run.machine = machine_facts();
    run.tables = {face_table(), asset_table()};
    double work = 0;
    for (const std::uint64_t faces : options.faces)
        work += static_cast<double>(faces) * (faces <= options.repeated_faces ? kRepetitions : 1);
    for (const unsigned count : options.assets) work += static_cast<double>(count * options.faces_of_assets);
    const formats::TemporaryFolder folder("dgm-bench");
    ProgressBar bar(quiet, work * static_cast<double>(options.threads.size()));
    add_mesh_rows(run.tables[0], options, folder.path(), bar);
    add_batch_rows(run.tables[1], options, folder.path(), bar);
    add_exponents(run.tables[0], "faces", "cpu_seconds", "CPU time of a bake", run.findings);
    add_exponents(run.tables[0], "faces", "wall_seconds", "wall time of a bake", run.findings);
    add_exponents(run.tables[0], "faces", "memory_mib", "peak memory of a bake", run.findings);
    add_exponents(run.tables[1], "assets", "wall_seconds", "wall time of a batch", run.findings);
    run.settings = {{"faces", fmt::format("{}", fmt::join(options.faces, ", "))},
                    {"assets", fmt::format("{}", fmt::join(options.assets, ", "))},
                    {"threads", fmt::format("{}", fmt::join(options.threads, ", "))},
                    {"grid", fmt::format("{0}x{0}", options.side)},
                    {"repetitions", fmt::format("{} up to {} faces, else 1", kRepetitions, options.repeated_faces)},
                    {"exponents", "least squares on logarithms, +- twice the standard error"}};
    return run;
}

}  // namespace dgm::bench
