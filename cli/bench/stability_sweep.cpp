// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/stability_sweep.cpp
#include "bench/stability_sweep.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "baking/option_names.h"
#include "bench/columns.h"
#include "bench/hard_meshes.h"
#include "bench/machine_facts.h"
#include "bench/progress_bar.h"
#include "bench/repeat.h"
#include "bench/result_figures.h"
#include "files/temporary_folder.h"
#include "mesh/mesh_writer.h"
#include "model/codes.h"
#include "tool/words.h"

namespace dgm::bench {
namespace {

namespace fs = std::filesystem;
using bake::AssetResult;

struct Family {
    const char* name;
    const char* meaning;
    std::vector<double> levels;  ///< ever harder
    std::function<model::TriMesh(double)> make;
};

const std::vector<Family>& families() {
    static const std::vector<Family> all{
        {"sliver", "width of one strip of triangles, of the others'", {1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15}, sliver_dome},
        {"offset", "distance from the origin, in diagonals", {0, 1e3, 1e5, 1e7, 1e9}, offset_dome},
        {"scale", "size, source units", {1, 1e-3, 1e-6, 1e-9, 1e-12}, scaled_dome},
        {"scale up", "size, source units", {1, 1e3, 1e6, 1e9, 1e12}, scaled_dome},
        {"grading", "widest cell / narrowest", {1, 1e2, 1e4, 1e6, 1e9, 1e12}, graded_dome},
        {"valence",
         "neighbours of one vertex",
         {6, 100, 1000, 10000},
         [](double v) { return fan_cone(static_cast<std::uint32_t>(v)); }},
        {"aspect", "length / circumference of a tube", {1, 10, 100, 1000}, tube},
        {"genus", "holes through a slab", {0, 1, 2, 4, 8, 16}, [](double g) {
             return pierced_slab(static_cast<std::uint32_t>(g));
         }}};
    return all;
}

std::vector<Family> chosen(const std::vector<std::string>& names) {
    if (names.empty()) return families();
    std::vector<Family> out;
    for (const std::string& name : names) {
        const auto found =
            std::find_if(families().begin(), families().end(), [&](const Family& f) { return f.name == name; });
        if (found == families().end())
            throw model::Error(model::codes::kUsage, tool::unknown_word("family of meshes", name, family_names()));
        out.push_back(*found);
    }
    return out;
}

Table empty_table() {
    Table t;
    t.key = "stability";
    t.title = "Harder and harder meshes";
    t.note =
        "Each family of meshes gets harder by one number. A method that refuses, or that a limit stopped, has no "
        "figures; "
        "the outcome says why. Errors in % of the diagonal; one bake each, so times have no spread and no ratio can be "
        "had from them.";
    t.columns =
        joined({{key_column("family", "family"), exact_column("hardness", "hardness", "", Sense::kNone),
                 key_column("level", "level"), key_column("method", "method"), text_column("outcome", "outcome"),
                 text_column("maps", "maps made by"), exact_column("rms_percent", "rms", "%", Sense::kLower, 0.01),
                 exact_column("hausdorff_percent", "max", "%", Sense::kLower, 0.05),
                 exact_column("stretch_l2", "stretch", "", Sense::kLower, 1e-3)},
                bake_columns()});
    t.plots = {{"Error as it gets harder", "hardness", "rms_percent", "method", "family", true},
               {"Time as it gets harder", "hardness", "cpu_seconds", "method", "family", true}};
    return t;
}

/// The family's meshes as files of `folder`, one for each level.
std::vector<fs::path> write_meshes(const Family& family, const fs::path& folder) {
    std::vector<fs::path> meshes;
    for (std::size_t k = 0; k < family.levels.size(); ++k) {
        meshes.push_back(folder / fmt::format("{}.obj", k));
        formats::write_obj(meshes.back(), family.make(family.levels[k]));
    }
    return meshes;
}

/// All meshes for each method in turn.
std::vector<BakeTask> tasks_of(const StabilityOptions& options, const std::vector<fs::path>& meshes) {
    std::vector<BakeTask> tasks;
    for (const std::string& method : options.methods)
        for (const fs::path& mesh : meshes) {
            tasks.push_back({mesh, {}});
            tasks.back().options.size = {options.side, options.side};
            tasks.back().options.method = *bake::method_of(method);
        }
    return tasks;
}

Row result_row(const Table& table, const Family& family, double level, const std::string& method,
               const AssetResult& result) {
    RowBuilder row(table);
    row.set("family", std::string(family.name));
    row.set("hardness", exactly(level));
    row.set("level", fmt::format("{:g}", level));
    row.set("method", method);
    row.set("outcome", result.error ? error_name(*result.error) : "ok");
    if (result.outcome == bake::Outcome::kBaked) {
        const bake::SurfaceError& error = result.report.error;
        row.set("maps", methods_of(result));
        row.set("rms_percent", exactly(100 * error.rms / error.diagonal));
        row.set("hausdorff_percent", exactly(100 * error.hausdorff / error.diagonal));
        row.set("stretch_l2", exactly(worst_stretch(result)));
        set_bake(row, {result});
    }
    return row.row();
}

}  // namespace

std::vector<std::string> family_names() {
    std::vector<std::string> out;
    for (const Family& f : families()) out.emplace_back(f.name);
    return out;
}

Run sweep_stability(const StabilityOptions& options, bool quiet) {
    const std::vector<Family> asked = chosen(options.families);
    for (const std::string& method : options.methods)
        if (!bake::method_of(method))
            throw model::Error(
                model::codes::kUsage,
                tool::unknown_word("method", method, {bake::kMethodNames.begin(), bake::kMethodNames.end()}));
    Run run;
    run.command = "stability";
    run.machine = machine_facts();
    run.tables = {empty_table()};
    Table& table = run.tables.front();
    const formats::TemporaryFolder folder("dgm-bench");
    BakeRepeats once;
    once.repetitions = 1;
    once.jobs = options.jobs;
    once.time_limit_seconds = options.time_limit_seconds;
    ProgressBar bar(quiet, static_cast<double>(asked.size() * options.methods.size()));
    for (const Family& family : asked) {
        const std::vector<fs::path> meshes = write_meshes(family, folder.path());
        // All methods' at once: a bake that runs out of time keeps one core busy, and the others need not wait for it.
        const std::vector<BakeTask> tasks = tasks_of(options, meshes);
        bar.begin(family.name, static_cast<double>(options.methods.size()));
        const std::vector<std::vector<AssetResult>> results = bake_all(
            tasks, once, folder.path(), [&](double s) { bar.update(s); },
            [&](std::size_t k) { bar.at(fmt::format("{} {}", family.name, bake::name_of(tasks[k].options.method))); });
        for (std::size_t m = 0; m < options.methods.size(); ++m)
            for (std::size_t k = 0; k < meshes.size(); ++k)
                table.rows.push_back(result_row(table, family, family.levels[k], options.methods[m],
                                                results[m * meshes.size() + k].front()));
    }
    run.findings = failure_lines(table);
    for (const Family& family : asked)
        run.settings.emplace_back("hardness of " + std::string(family.name), family.meaning);
    run.settings.emplace_back("methods", fmt::format("{}", fmt::join(options.methods, ", ")));
    run.settings.emplace_back("grid", fmt::format("{0}x{0}", options.side));
    run.settings.emplace_back("time limit", fmt::format("{} s a bake", options.time_limit_seconds));
    run.settings.emplace_back("repetitions", "1");
    return run;
}

}  // namespace dgm::bench
