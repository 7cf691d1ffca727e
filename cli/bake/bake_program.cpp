// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bake/bake_program.cpp
#include "bake/bake_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>
#include <nlohmann/json.hpp>
#include <utility>

#include "bake/live_index.h"
#include "bake/notes.h"
#include "bake/options.h"
#include "bake/progress_view.h"
#include "bake/raw_options.h"
#include "baking/up_to_date.h"
#include "batch/batch_report_json.h"
#include "batch/dependency_file.h"
#include "batch/left_over.h"
#include "batch/memory_budget.h"
#include "batch/merge_reports.h"
#include "batch/repeat_command.h"
#include "batch/report_text.h"
#include "files/atomic_file.h"
#include "files/output_file.h"
#include "model/codes.h"
#include "model/file_errors.h"
#include "model/shortage.h"
#include "process/exr_apart.h"
#include "process/hdf5_apart.h"
#include "process/json_apart.h"
#include "process/sandbox.h"
#include "report/page_job.h"
#include "report/report_files.h"
#include "scene/scene_outcome.h"
#include "worker/output_files.h"

namespace dgm::bake {
namespace {

namespace fs = std::filesystem;
namespace codes = model::codes;

void say(std::FILE* to, const std::string& text) {
    std::fputs(text.c_str(), to);
}

fs::path spelled_out(const fs::path& path) {
    std::error_code ignored;
    return fs::weakly_canonical(path, ignored);
}

/// Finds out at the start what would otherwise be found out after hours.
void check_files(const CommandLine& line, const BatchPlan& plan) {
    std::error_code ignored;
    std::vector<fs::path> inputs{line.bake.texture, line.bake.material_file, line.scene};
    for (const PlannedAsset& asset : plan.assets)
        inputs.insert(inputs.end(), {asset.source, asset.options.texture, asset.options.material_file});
    const std::array further{std::pair(line.report, "report"), std::pair(line.depfile, "depfile")};
    for (const auto& [file, what] : further) formats::refuse_input_as_output(file, inputs, what);
    if (!line.report.empty() && !line.depfile.empty() && formats::is_same_file(line.report, line.depfile) &&
        !formats::destination_of(line.report).is_through)
        throw model::Error(codes::kUsage, "the report and the depfile would overwrite each other",
                           line.depfile.string());
    if (!line.bake.texture.empty() && !fs::is_regular_file(line.bake.texture, ignored))
        throw model::missing_file(line.bake.texture);
    for (const PlannedAsset& asset : plan.assets)
        for (const fs::path& output : outputs_of(asset)) {
            if (!line.bake.texture.empty() && spelled_out(output) == spelled_out(line.bake.texture))
                throw model::Error(codes::kUsage, "the output would overwrite the texture", output.string());
            for (const auto& [file, what] : further)
                if (!file.empty() && spelled_out(output) == spelled_out(file))
                    throw model::Error(codes::kUsage, fmt::format("the {} would overwrite an output", what),
                                       output.string());
        }
}

/// Reports are of one batch: a larger file is none.
constexpr std::uint64_t kMostReportBytes = std::uint64_t{2} << 30;

/// Textures and material libraries are known once the assets are baked.
void check_inputs_kept(const fs::path& file, const std::vector<AssetResult>& results, const char* what) {
    for (const AssetResult& result : results) formats::refuse_input_as_output(file, result.inputs, what);
}

/// As formats::check_output(). An index has pages beside it.
void check_page(const fs::path& report) {
    formats::check_output(report);
    if (formats::destination_of(report).is_through)
        throw model::Error(codes::kUsage, "an HTML report is a file with pages beside it", report.string());
}

/// The report and the depfile get their folders, and can be written.
void prepare_outputs(const CommandLine& line) {
    for (const fs::path& file : {line.report, line.depfile}) {
        if (file.empty()) continue;
        formats::make_folder_of(file);
        if (file == line.report && line.html_report)
            check_page(file);
        else
            formats::check_output(file);
    }
}

/// Pages take seconds each. @return true if a signal ended it
bool write_html(const CommandLine& line, const report::ReportToShow& shown) {
    const auto tell = [&](std::size_t done, std::size_t all) {
        const bool step = done == all || done * 10 / all != (done - 1) * 10 / all;
        if (!line.quiet && line.progress != ProgressStyle::kNone && step)
            say(stderr, fmt::format("dgm-bake: report: {} of {} page{}\n", done, all, all == 1 ? "" : "s"));
    };
    const report::PageLimits limits{line.batch.jobs, line.batch.time_limit_seconds, line.batch.memory_bytes};
    const report::HtmlReport html = report::html_report(line.report, shown, limits, tell);
    formats::write_output(line.report, html.index);
    if (!line.quiet)
        say(stdout, fmt::format("{}: report, {} page{} made, {} kept, {} failed\n",
                                printable(line.report.lexically_normal().string()), html.made,
                                html.made == 1 ? "" : "s", html.kept, html.failed));
    return html.interrupted;
}

int merge(const CommandLine& line) {
    // The report may take the place of one that it was merged of: all of them are in memory before it is written.
    const JsonApart json([](std::string_view text, const fs::path& file) {
        const std::string inside = report::report_in_index(text);
        return parse_json(inside.empty() ? text : inside, file);
    });
    std::vector<NamedReport> reports;
    for (const fs::path& path : line.to_merge) reports.push_back({path.string(), read_json(path, kMostReportBytes)});
    const MergedReport merged = merge_reports(std::move(reports));
    formats::make_folder_of(line.report);
    if (line.report.empty()) {
        say(stdout, merged.text);
    } else if (line.html_report) {
        check_page(line.report);
        try {
            if (write_html(line, {nlohmann::json::parse(merged.text), true, line.bake.asset_roots}))
                return static_cast<int>(model::ExitCode::kInterrupted);
        } catch (const model::Error& error) {
            if (error.code().number != codes::kReportUnreadable.number) throw;
            std::string names;
            for (const fs::path& path : line.to_merge) names += (names.empty() ? "" : ", ") + path.string();
            throw model::Error(error.code(), error.what(), names);
        }
    } else {
        formats::write_output(line.report, merged.text);
    }
    return static_cast<int>(merged.exit);
}

/// Build systems go by times: what is up to date by content must not look older than what it was made from.
void touch_outputs(const std::vector<AssetResult>& results) {
    for (const AssetResult& result : results)
        if (result.outcome == Outcome::kUpToDate)
            for (const OutputFile& file : result.files)
                if (utimensat(AT_FDCWD, file.path.c_str(), nullptr, 0) != 0)
                    throw model::Error(codes::kWriteFailed,
                                       std::string("its time cannot be set: ") + std::strerror(errno),
                                       file.path.string());
}

/// Rules for outputs that exist now; other assets have no files that a build could use.
std::vector<DependencyRule> rules_of(const std::vector<AssetResult>& results) {
    std::vector<DependencyRule> rules;
    for (const AssetResult& result : results) {
        if (result.files.empty()) continue;
        DependencyRule& rule = rules.emplace_back();
        for (const OutputFile& file : result.files) rule.outputs.push_back(file.path);
        rule.inputs = result.inputs;
    }
    return rules;
}

int print_plan(const BatchPlan& plan, const std::optional<scene::Scene>& scene) {
    std::vector<AssetResult> results(plan.assets.size());
    if (scene) say(stdout, scene::plan_text(*scene));
    for (std::size_t k = 0; k < plan.assets.size(); ++k) {
        const PlannedAsset& asset = plan.assets[k];
        results[k].error = asset.refusal;
        if (asset.refusal) say(stderr, failure_story(asset.source.string(), *asset.refusal));
        for (const fs::path& output : outputs_of(asset))
            if (!asset.refusal)
                say(stdout, fmt::format("{} -> {}\n", printable(asset.source.string()),
                                        printable(output.lexically_normal().string())));
    }
    for (const std::string& text : left_out_lines(plan.left_out, true)) say(stdout, text + '\n');
    return static_cast<int>(worst_exit(results));
}

void tell_left_over(const CommandLine& line, const std::vector<LeftOver>& files) {
    if (line.quiet) return;
    for (const std::string& text : left_over_lines(files)) say(stdout, text + '\n');
}

class Conversation {
 public:
    Conversation(const CommandLine& line, const BatchPlan& plan)
        : line_(line),
          plan_(plan),
          index_(line.html_report ? line.report : fs::path(), plan),
          view_(line.quiet ? ProgressStyle::kNone : line.progress, names(plan), weights(plan)) {
        observer_.on_start = [this](std::size_t k) { view_.start(k); };
        observer_.on_progress = [this](std::size_t k, std::string_view stage, double share) {
            view_.update(k, printable(stage), share);
        };
        observer_.on_notice = [this](std::size_t k, const Notice& said) { notice(k, said); };
        observer_.on_end = [this](std::size_t k, const AssetResult& result) {
            view_.end(k);
            index_.add(k, result);
        };
        observer_.on_finish = [this](std::size_t k, const AssetResult& result) { finished(k, result); };
        observer_.on_tick = [this] { view_.tick(); };
    }
    [[nodiscard]] const BatchObserver& observer() const { return observer_; }
    void end(const std::vector<AssetResult>& results) {
        view_.clear();
        if (worst_exit(results) == model::ExitCode::kInterrupted)
            say(stderr, failure_story({}, model::Error(codes::kInterrupted, summary_line(results))));
        else if (!line_.quiet)
            tell_summary(results);
    }

 private:
    static std::vector<std::string> names(const BatchPlan& plan) {
        std::vector<std::string> out;
        for (const PlannedAsset& asset : plan.assets) out.push_back(printable(asset.source.filename().string()));
        return out;
    }
    /// Memory stands for time.
    static std::vector<double> weights(const BatchPlan& plan) {
        std::vector<double> out;
        for (const PlannedAsset& asset : plan.assets)
            out.push_back(static_cast<double>(estimate_peak(asset.source, asset.options)));
        return out;
    }
    /// Forty garments have forty open borders: of several meshes, notes are counted.
    void notice(std::size_t k, const Notice& notice) {
        if (line_.quiet) return;
        if (!notice.kind.empty() && plan_.assets.size() > 1 && !line_.verbose) return notes_.add(k, notice);
        view_.clear();
        say(stderr,
            fmt::format("dgm-bake: {}: {}\n", printable(plan_.assets[k].source.string()), printable(notice.text)));
    }
    void tell_summary(const std::vector<AssetResult>& results) {
        if (line_.verbose)
            for (const std::string& lack : sandbox_lacks()) say(stderr, fmt::format("dgm-bake: sandbox: {}\n", lack));
        if (const std::string notes = notes_.line(results.size()); !notes.empty())
            say(stderr, fmt::format("dgm-bake: {}\n", notes));
        if (results.size() != 1) say(stdout, summary_line(results) + '\n');
        for (const std::string& text : left_out_lines(plan_.left_out, line_.verbose)) say(stdout, text + '\n');
    }
    void finished(std::size_t k, const AssetResult& result) {
        view_.clear();
        if (result.error)
            say(stderr, failure_story(plan_.assets[k].source.string(), *result.error, result.worker_output));
        const bool is_new = result.outcome == Outcome::kBaked;
        if (line_.quiet || !(is_new || result.outcome == Outcome::kUpToDate)) return;
        say(stdout, (is_new ? result_line(result) : up_to_date_line(result)) + '\n');
        if (is_new && result.report.search && !line_.verbose)
            say(stdout, "  " + search_story(*result.report.search, result.report.error.diagonal) + '\n');
        if (line_.verbose)
            for (const std::string& detail : detail_lines(result.report)) say(stdout, detail + '\n');
        std::fflush(stdout);
    }

    const CommandLine& line_;
    const BatchPlan& plan_;
    LiveIndex index_;
    Notes notes_;
    ProgressView view_;
    BatchObserver observer_;
};

/// @return the worse of `exit` and what the scene's budget gives
model::ExitCode tell_scene(const CommandLine& line, const scene::Scene& scene, const scene::SceneOutcome& outcome,
                           model::ExitCode exit) {
    if (!line.quiet) say(stdout, scene::to_text(scene, outcome));
    for (const std::string& warning : outcome.warnings)
        if (!line.quiet) say(stderr, fmt::format("dgm-bake: warning: {}\n", printable(warning)));
    if (!outcome.over_budget) return exit;
    say(stderr, failure_story(line.scene.string(), *outcome.over_budget));
    return worse(exit, outcome.over_budget->code().exit);
}

/// While a batch runs it answers signals itself (batch_runner.h). Before, there is nothing to clean up; after it, what
/// is left takes milliseconds and is better done.
class SignalsAround {
 public:
    SignalsAround() {
        set([](int) { _exit(static_cast<int>(model::ExitCode::kInterrupted)); });
    }
    void batch_done() { set(SIG_IGN); }

 private:
    static void set(void (*handler)(int)) {
        for (const int number : {SIGINT, SIGTERM, SIGHUP}) signal(number, handler);
    }
};

int run(const CommandLine& line) {
    SignalsAround signals;
    if (!line.to_merge.empty()) return merge(line);
    std::optional<scene::Scene> scene;
    if (!line.scene.empty()) scene = scene::read_scene(line.scene);
    BatchPlan plan = scene ? scene::plan_batch(*scene, line.plan.output.empty() ? fs::path(".") : line.plan.output)
                           : plan_batch(line.plan, line.bake);
    for (PlannedAsset& asset : plan.assets) asset.options.asset_roots = line.bake.asset_roots;  // a scene grants none
    check_files(line, plan);
    std::vector<LeftOver> left_over;
    if (!scene) left_over = find_left_over(plan, !line.plan.output.empty());
    if (line.shard) keep_shard(plan, *line.shard);
    if (line.dry_run) {
        const int exit = print_plan(plan, scene);
        tell_left_over(line, left_over);
        return exit;
    }
    prepare_outputs(line);
    Conversation conversation(line, plan);
    BatchOptions batch = line.batch;
    batch.wants_inputs = !line.report.empty() || !line.depfile.empty();
    const std::vector<AssetResult> results = run_batch(plan, batch, conversation.observer());
    signals.batch_done();
    conversation.end(results);
    if (line.prune && worst_exit(results) != model::ExitCode::kInterrupted) prune(left_over, results);
    tell_left_over(line, left_over);
    std::optional<scene::SceneOutcome> outcome;
    model::ExitCode exit = worst_exit(results);
    if (scene && exit != model::ExitCode::kInterrupted) {
        outcome = scene::scene_outcome(*scene, plan, results);
        exit = tell_scene(line, *scene, *outcome, exit);
    }
    bool interrupted = false;
    check_inputs_kept(line.report, results, "report");
    check_inputs_kept(line.depfile, results, "depfile");
    if (!line.report.empty()) {
        nlohmann::json report = nlohmann::json::parse(batch_report_json(plan, line.batch, results, generator()));
        if (scene)
            for (nlohmann::json& asset : report["assets"])
                asset["command"] = repeat_scene_command(line.scene, plan.folder);
        if (outcome) scene::add_scene(report, *scene, *outcome);
        add_other_files(report, plan.left_out, left_over);
        if (line.html_report)
            interrupted = write_html(line, {std::move(report), false, line.bake.asset_roots});
        else
            formats::write_output(line.report,
                                  report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n');
    }
    if (!line.depfile.empty()) {
        touch_outputs(results);
        formats::write_output(line.depfile, dependency_file(rules_of(results)));
    }
    return static_cast<int>(interrupted ? model::ExitCode::kInterrupted : exit);
}

int run_command_line(int argc, const char* const* argv) {
    CLI::App app;
    Raw raw;
    describe(app, raw);
    if (tool::print_manual(argc, argv, app, manual())) return static_cast<int>(model::ExitCode::kOk);
    const auto line = parse_command_line(argc, argv);
    if (const Answer* answer = std::get_if<Answer>(&line)) {
        say(stdout, *answer);
        return static_cast<int>(model::ExitCode::kOk);
    }
    const Hdf5Apart hdf5;
    const ExrApart exr;
    return run(std::get<CommandLine>(line));
}

}  // namespace

int bake_program(int argc, char** argv, const BakeFunction& bake) {
    model::Error failure(codes::kInternal, "unknown exception");
    try {
        if (is_worker(argc, argv)) return run_worker(bake, report::make_page);
        // A reader of our stdout that leaves (`| head`) must not leave temporaries behind.
        signal(SIGPIPE, SIG_IGN);
        const int exit_code = run_command_line(argc, argv);
        if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit_code;
        failure = model::Error(codes::kWriteFailed, "the results cannot be written to standard output");
    } catch (const model::Error& error) { failure = error; } catch (const std::exception& error) {
        failure = model::error_of(error);
    }
    say(stderr, failure_story(failure.place(), failure));
    return static_cast<int>(failure.code().exit);
}

}  // namespace dgm::bake
