// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/run_sweep.cpp
#include "bench/run_sweep.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "bench/interrupt.h"
#include "bench/machine_facts.h"
#include "bench/runtime_error.h"
#include "files/temporary_folder.h"

namespace dgm::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kPaperSide = 81;

/// Bakes a mesh with the defaults. @throws the bake's error
fs::path baked(const fs::path& mesh, std::uint32_t side, const fs::path& folder, double time_limit) {
    bake::BakeOptions options;
    options.size = {side, side};
    BakeRepeats once;
    once.repetitions = 1;
    once.time_limit_seconds = time_limit;
    const auto results = bake_repeatedly({mesh}, options, once, folder, [](double) {});
    if (results.front().error) throw model::Error(*results.front().error);
    return results.front().files.front().path;
}

Subject subject_of(const Asset& asset, const std::string& name) {
    std::uint32_t best = 0;
    for (std::uint32_t k = 1; k < asset.chart_count(); ++k)
        if (take(asset.chart(k)).sample_count() > take(asset.chart(best)).sample_count()) best = k;
    const Chart chart = take(asset.chart(best));
    return {name, fmt::format("{}x{}", chart.rows(), chart.cols()), chart,
            chart.rows() == kPaperSide && chart.cols() == kPaperSide};
}

/// Adds the findings of one subject's rows, a sentence each.
void add_findings(const Run& run, const Subject& subject, std::vector<std::string>& out) {
    const auto find = [&](const Table& table, const std::string& key, const std::string& value) -> std::ptrdiff_t {
        for (std::size_t row = 0; row < table.rows.size(); ++row)
            if (table.text(row, "asset") == subject.asset && table.text(row, "grid") == subject.grid &&
                table.text(row, key) == value)
                return static_cast<std::ptrdiff_t>(row);
        return -1;
    };
    const Table& ticks = run.tables.front();
    const auto figure = [&](std::ptrdiff_t row, const char* key) {
        return three_digits(ticks.number(static_cast<std::size_t>(row), key));
    };
    const auto paper = find(ticks, "rule", "printed"), smooth = find(ticks, "setting", "smooth force");
    const auto geodesic = find(ticks, "setting", "geodesic"), compact = find(ticks, "setting", "compact end");
    const std::string who = subject.asset + " " + subject.grid + ": ";
    out.push_back(who + "a tick in the paper's setting takes " + figure(paper, "p50_us") + " us (p99.9 " +
                  figure(paper, "p999_us") + " us); the force jumps by up to " + figure(paper, "force_jump") +
                  " of f_max, with the smooth rule by " + figure(smooth, "force_jump") + " at " +
                  figure(smooth, "p50_us") + " us");
    const auto grid = find(ticks, "setting", "grid, compact end");
    const auto off = [&](std::ptrdiff_t row) {
        return figure(row, "inside_error_max") + " of its depth, at seams and borders by " +
               figure(row, "border_error_max") + ", at " + figure(row, "p50_us") + " us (p99 " + figure(row, "p99_us") +
               " us)";
    };
    out.push_back(who + "the default footprint is off the exact geodesic dent by at most " + off(compact) +
                  "; a geodesic one by " + off(geodesic) + "; eq. 7 as printed by " + off(grid));
}

}  // namespace

const char* name_of(Path path) {
    return path == Path::kStroke ? "stroke" : path == Path::kRandom ? "random" : "recorded";
}

void each_subject(const std::vector<fs::path>& assets, const std::vector<std::uint32_t>& sizes, const fs::path& folder,
                  double time_limit_seconds, ProgressBar& bar, const std::function<void(const Subject&)>& visit) {
    for (const fs::path& path : assets) {
        const bool is_map = path.extension() == ".dgm";
        for (const std::uint32_t side : is_map ? std::vector<std::uint32_t>{0} : sizes) {
            const std::string name = path.filename().string();
            bar.begin(name + (is_map ? "" : fmt::format(" {}x{}", side, side)), 1);
            const fs::path file = is_map ? path : baked(path, side, folder, time_limit_seconds);
            const Asset asset = take(Asset::open(file.c_str()));
            visit(subject_of(asset, name));
        }
    }
}

ToolWay path_for(const Subject& subject, Path kind, const RunSweepOptions& options, std::size_t ticks) {
    const State state = subject.state();
    const auto alone = [](std::vector<Vec3> places) { return ToolWay{1, std::move(places), {}}; };
    if (kind == Path::kStroke) return alone(stroke_path(state, ticks));
    if (kind == Path::kRandom) return alone(random_path(state, ticks));
    if (options.path.empty()) return alone(replayed_path(state, ticks));
    const auto offset = subject.chart.offset();
    return recorded_path(options.path, {offset[0], offset[1], offset[2]}, ticks);
}

std::vector<Column> subject_columns(const std::vector<Column>& rest) {
    return joined({{key_column("asset", "asset"), key_column("grid", "grid")}, rest});
}

std::vector<Column> percentile_columns() {
    return {time_column("p50_us", "p50", "us"), time_column("p99_us", "p99", "us"),
            time_column("p999_us", "p99.9", "us")};
}

SubjectRow::SubjectRow(const Table& table, const Subject& subject) : RowBuilder(table) {
    set("asset", subject.asset);
    set("grid", subject.grid);
}

void SubjectRow::set_percentiles(const TickTimes& times) {
    set("p50_us", times.median);
    set("p99_us", times.p99);
    set("p999_us", times.p999);
}

State Subject::state() const {
    return take(State::create(chart));
}

Run sweep_runtime(const RunSweepOptions& options, bool quiet) {
    Run run;
    run.command = "run";
    run.machine = machine_facts();
    // A path that cannot be read is reported before it is needed.
    if (!options.path.empty()) (void)recorded_path(options.path, {0, 0, 0}, 1);
    run.tables = {tick_table(), tracking_table(), contact_table(), level_table()};
    std::vector<std::uint32_t> sizes = options.sizes;
    if (std::find(sizes.begin(), sizes.end(), kPaperSide) == sizes.end()) sizes.insert(sizes.begin(), kPaperSide);

    const formats::TemporaryFolder folder("dgm-bench");
    ProgressBar bar(quiet, static_cast<double>(options.assets.size() * sizes.size()));
    each_subject(options.assets, sizes, folder.path(), options.time_limit_seconds, bar, [&](const Subject& subject) {
        add_tick_rows(run.tables[0], subject, options, bar);
        stop_if_interrupted();
        add_tracking_rows(run.tables[1], subject, options);
        add_contact_rows(run.tables[2], subject);
        stop_if_interrupted();
        add_level_rows(run.tables[3], subject);
        add_findings(run, subject, run.findings);
    });
    run.tables.push_back(kernel_table());
    run.settings = {
        {"sizes", fmt::format("{}", fmt::join(sizes, ", "))},
        {"ticks", std::to_string(options.ticks)},
        {"warm-up", "500 ticks, 200 searches, 3 contacts"},
        {"blocks", "5; p50 to p99.9 are the median of the blocks'"},
        {"kernel", "sigma 16 at b = 11; b^2 / sigma is the same for every b"},
        {"tool", "d_max 4 mean steps; strokes of 0.15 steps a tick, up to 2.5 steps deep"},
        {"recorded path", options.path.empty() ? "a stomach pressed, poked and pulled, at the same places of each map"
                                               : options.path.filename().string()},
        {"spread", "95 % interval for another run's median (Student's t on logarithms, at least 2 %)"}};
    return run;
}

}  // namespace dgm::bench
