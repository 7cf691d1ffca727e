// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/bake_sweep.cpp
#include "bench/bake_sweep.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "baking/option_names.h"
#include "baking/pipeline.h"
#include "bench/columns.h"
#include "bench/file_times.h"
#include "bench/machine_facts.h"
#include "bench/recommend.h"
#include "bench/result_figures.h"
#include "files/temporary_folder.h"
#include "model/codes.h"
#include "tool/words.h"

namespace dgm::bench {
namespace {

namespace fs = std::filesystem;
using bake::AssetResult;

/// dgm-validate allows the same: other random points on the same surfaces (grid_search.h).
constexpr double kRmsTolerance = 0.01, kMaxTolerance = 0.05;

template <class Table>
auto value_for(const Table& table, const std::string& word, const char* what) {
    const auto value = bake::value_of(table, word);
    if (!value) {
        std::vector<std::string> words;
        words.reserve(std::size(table));
        for (const auto& row : table) words.emplace_back(row.name);
        throw model::Error(model::codes::kUsage, tool::unknown_word(what, word, words));
    }
    return *value;
}

bake::BakeOptions options_of(const BakePoint& point) {
    bake::BakeOptions out;
    out.size = {point.side, point.side};
    out.method = value_for(bake::kMethods, point.method, "method");
    out.fit = value_for(bake::kFitNames, point.fit, "fit");
    out.precision = value_for(bake::kPrecisionNames, point.precision, "precision");
    if (point.layers == "all") return out;
    std::stringstream words(point.layers);
    for (std::string word; std::getline(words, word, '+');) {
        if (std::find(bake::kLayerNames.begin(), bake::kLayerNames.end(), word) == bake::kLayerNames.end())
            throw model::Error(model::codes::kUsage,
                               tool::unknown_word("layer", word, {bake::kLayerNames.begin(), bake::kLayerNames.end()}));
        out.layers.push_back(word);
    }
    return out;
}

constexpr const char* kStages[] = {"import", "repair", "textures", "map", "fit", "layers", "measure", "write"};

Table empty_table() {
    Table t;
    t.key = "bake";
    t.title = "Bakes";
    t.note =
        "Each bake is a process of its own, as dgm-bake runs it. Errors are measured on what was stored, in % of the "
        "diagonal; CPU is user and system time of the whole process, wall the time until the file is in place. Load: "
        "open and check every layer's hash; reconstruct: vertices, normals and triangles; both on one thread with warm "
        "pages. The row 'paper' is the paper's setting: 81x81, samples on the surface.";
    t.columns =
        joined({{key_column("asset", "asset"), key_column("point", "point"), key_column("method", "method"),
                 key_column("grid", "grid"), key_column("precision", "precision"), key_column("fit", "fit"),
                 key_column("layers", "layers"), text_column("outcome", "outcome"), text_column("series", "drawn as"),
                 exact_column("rms_percent", "rms", "%", Sense::kLower, kRmsTolerance),
                 exact_column("hausdorff_percent", "max", "%", Sense::kLower, kMaxTolerance),
                 exact_column("psnr", "PSNR", "dB", Sense::kHigher, 0.001),
                 exact_column("normal_degrees", "normals", "degrees", Sense::kLower, kRmsTolerance),
                 exact_column("stretch_l2", "stretch", "", Sense::kLower, 1e-6),
                 exact_column("flips", "flips", "", Sense::kLower),
                 exact_column("turned_faces", "turned faces", "", Sense::kLower),
                 exact_column("utilisation", "utilisation", "", Sense::kHigher, 1e-6),
                 exact_column("bytes", "file", "bytes", Sense::kLower),
                 exact_column("geometry_bytes", "geometry", "bytes", Sense::kLower)},
                bake_columns(),
                {time_column("load_ms", "load", "ms"), time_column("reconstruct_ms", "reconstruct", "ms")}});
    for (const char* stage : kStages) t.columns.push_back(time_column(std::string(stage) + "_seconds", stage, "s"));
    t.plots = {{"Error against bake time", "cpu_seconds", "rms_percent", "series", "asset", false},
               {"Error against file size", "bytes", "rms_percent", "series", "asset", false},
               {"Largest error against file size", "bytes", "hausdorff_percent", "series", "asset", false},
               {"Error of normals against file size", "bytes", "normal_degrees", "series", "asset", false},
               {"Error against load time", "load_ms", "rms_percent", "series", "asset", false},
               {"Error against reconstruct time", "reconstruct_ms", "rms_percent", "series", "asset", false}};
    return t;
}

/// Differences of the point from the default, except the grid: they decide its colour.
std::string series_of(const BakePoint& point) {
    const BakePoint usual = default_point();
    std::string out = point.method;
    if (point.precision != usual.precision) out += " " + point.precision;
    if (point.fit != usual.fit) out += " fit " + point.fit;
    if (point.layers != usual.layers) out += " " + point.layers;
    return out;
}

class BakeRow : public RowBuilder {
 public:
    BakeRow(const Table& table, const BakePoint& point) : RowBuilder(table) {
        set("point", point == paper_point() ? "paper" : point == default_point() ? "default" : "");
        set("method", point.method);
        set("grid", fmt::format("{0}x{0}", point.side));
        set("precision", point.precision);
        set("fit", point.fit);
        set("layers", point.layers);
        set("series", series_of(point));
    }

    void set_measured(const std::vector<AssetResult>& results, const FileTimes& file) {
        const bake::BakeReport& report = results.front().report;
        const bake::SurfaceError& error = report.error;
        set("rms_percent", exactly(100 * error.rms / error.diagonal));
        set("hausdorff_percent", exactly(100 * error.hausdorff / error.diagonal));
        set("psnr", exactly(error.psnr()));
        set("normal_degrees", exactly(error.normal_rms_degrees));
        double flips = 0, turned = 0, samples = 0, used = 0;
        for (const bake::ChartReport& chart : report.charts) {
            const double here = static_cast<double>(chart.rows) * chart.cols;
            flips += static_cast<double>(chart.map.flips + chart.map.degenerate);
            turned += static_cast<double>(chart.turned_faces);
            samples += here;
            used += here * chart.utilisation;
        }
        set("stretch_l2", exactly(worst_stretch(results.front())));
        set("flips", exactly(flips));
        set("turned_faces", exactly(turned));
        set("utilisation", exactly(used / samples));
        set("bytes", exactly(static_cast<double>(file.bytes)));
        set("geometry_bytes", exactly(static_cast<double>(file.geometry_bytes)));
        set_bake(*this, results);
        set("load_ms", scaled(file.load_seconds, 1e3));
        set("reconstruct_ms", scaled(file.reconstruct_seconds, 1e3));
        for (const char* stage : kStages)
            set(std::string(stage) + "_seconds",
                figure_of(results, [&](const AssetResult& r) { return stage_seconds(r, stage); }));
    }
};

/// The points from `first` on that are baked in one go: as many as leave some 300 MB of files to be timed, one at
/// least.
std::size_t end_of_group(const std::vector<BakePoint>& points, std::size_t first) {
    constexpr double kMostSamples = 4e6;  // a sample takes 73 bytes with all layers
    double samples = 0;
    std::size_t end = first;
    for (; end < points.size(); ++end) {
        samples += static_cast<double>(points[end].side) * points[end].side;
        if (end > first && samples > kMostSamples) break;
    }
    return end;
}

/// Names of the assets as rows show them: the file's, with its folder where two are alike.
std::vector<std::string> names_of(const std::vector<fs::path>& assets) {
    std::vector<std::string> out;
    for (const fs::path& asset : assets) {
        const bool twice = std::count_if(assets.begin(), assets.end(), [&](const fs::path& other) {
                               return other.filename() == asset.filename();
                           }) > 1;
        out.push_back(((twice ? asset.parent_path().filename() : fs::path()) / asset.filename()).string());
    }
    return out;
}

/// Bakes the cheapest point once: brings the mesh and the program into memory.
void warm_up(const fs::path& asset, BakeRepeats repeats, const fs::path& folder) {
    repeats.repetitions = 1;
    BakePoint cheap = paper_point();
    cheap.side = 17;
    (void)bake_repeatedly({asset}, options_of(cheap), repeats, folder, [](double) {});
}

/// One asset of the sweep, with the folder and the bar that all share.
struct AssetSweep {
    const fs::path& asset;
    const std::string& name;
    const BakeRepeats& repeats;
    const fs::path& folder;
    ProgressBar& bar;

    [[nodiscard]] unsigned repetitions(const BakePoint& point) const {
        return repetitions_of(point, repeats.repetitions);
    }

    /// Bakes all points of a group in one go.
    [[nodiscard]] std::vector<std::vector<AssetResult>> bake_group(const std::vector<BakePoint>& group) const {
        std::vector<BakeTask> tasks;
        double group_work = 0;
        for (const BakePoint& point : group) {
            tasks.push_back({asset, options_of(point), repetitions(point), work_of(point, 1)});
            group_work += work_of(point, repetitions(point));
        }
        bar.begin(name, group_work);
        return bake_all(
            tasks, repeats, folder, [&](double s) { bar.update(s); },
            [&](std::size_t k) {
                bar.at(fmt::format("{} {} {}x{}", name, series_of(group[k]), group[k].side, group[k].side));
            });
    }
};

/// The row of one point; times loading of its file, and removes it.
Row measured_row(const Table& table, const std::string& name, const BakePoint& point,
                 const std::vector<AssetResult>& results) {
    const AssetResult& result = results.front();
    BakeRow row(table, point);
    row.set("asset", name);
    row.set("outcome", result.error ? error_name(*result.error) : methods_of(result));
    if (result.outcome == bake::Outcome::kBaked) {
        const fs::path& file = result.files.front().path;
        row.set_measured(results, measure_file(file));
        std::error_code ignored;
        fs::remove(file, ignored);
    }
    return row.row();
}

void sweep_asset(const AssetSweep& sweep, const std::vector<BakePoint>& points, Table& table) {
    for (std::size_t first = 0; first < points.size();) {
        const std::size_t end = end_of_group(points, first);
        const std::vector<BakePoint> group(points.begin() + static_cast<std::ptrdiff_t>(first),
                                           points.begin() + static_cast<std::ptrdiff_t>(end));
        first = end;
        const auto results = sweep.bake_group(group);
        // Loading is timed when no bake runs beside it.
        for (std::size_t k = 0; k < group.size(); ++k)
            table.rows.push_back(measured_row(table, sweep.name, group[k], results[k]));
    }
}

}  // namespace

Run sweep_bakes(const BakeSweepOptions& options, bool quiet) {
    const std::vector<BakePoint> points = plan_points(options);
    for (const BakePoint& point : points) (void)options_of(point);  // a wrong word is reported before an hour of bakes
    Run run;
    run.command = "bake";
    run.machine = machine_facts();
    run.tables.push_back(empty_table());
    Table& table = run.tables.front();

    double work = 0;
    for (const BakePoint& point : points) work += work_of(point, repetitions_of(point, options.repeats.repetitions));
    ProgressBar bar(quiet, work * static_cast<double>(options.assets.size()));
    const std::vector<std::string> names = names_of(options.assets);
    const formats::TemporaryFolder folder("dgm-bench");
    for (std::size_t a = 0; a < options.assets.size(); ++a) {
        bar.begin(names[a] + " warm-up", 0);
        warm_up(options.assets[a], options.repeats, folder.path());
        sweep_asset({options.assets[a], names[a], options.repeats, folder.path(), bar}, points, table);
        for (const std::string& line : recommend(table, names[a])) run.findings.push_back(line);
    }
    run.settings = {{"repetitions", std::to_string(options.repeats.repetitions)},
                    {"repetitions of large grids", "3 at most above 300 a side, 1 above 600"},
                    {"warm-up", "one bake at 17x17 of each asset, not counted"},
                    {"bakes at a time", std::to_string(options.repeats.jobs)},
                    {"threads of a bake", std::to_string(options.repeats.threads)},
                    {"combinations", options.full ? "all" : "one choice at a time"},
                    {"spread", "95 % interval for another run's median (Student's t on logarithms, at least 2 %)"}};
    return run;
}

}  // namespace dgm::bench
