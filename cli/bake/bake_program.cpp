// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bake/bake_program.cpp
#include "bake/bake_program.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <new>

#include "bake/options.h"
#include "bake/progress_view.h"
#include "dgm/atomic_file.h"
#include "model/codes.h"
#include "pipeline/output_files.h"
#include "pipeline/report_text.h"

namespace dgm::bake {
namespace {

namespace fs = std::filesystem;
namespace codes = model::codes;

constexpr const char* kGenerator = "dgm-bake " DGM_VERSION;

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
    if (!line.bake.texture.empty() && !fs::is_regular_file(line.bake.texture, ignored))
        throw model::Error(codes::kFileMissing, "there is no such texture image", line.bake.texture.string());
    for (const PlannedAsset& asset : plan.assets)
        for (const fs::path& output : {asset.dgm, asset.exr}) {
            if (output.empty()) continue;
            if (!line.bake.texture.empty() && spelled_out(output) == spelled_out(line.bake.texture))
                throw model::Error(codes::kUsage, "the output would overwrite the texture", output.string());
            if (!line.report.empty() && spelled_out(output) == spelled_out(line.report))
                throw model::Error(codes::kUsage, "the report would overwrite an output", output.string());
        }
    if (line.report.empty()) return;
    for (const PlannedAsset& asset : plan.assets)
        if (spelled_out(asset.source) == spelled_out(line.report))
            throw model::Error(codes::kUsage, "the report would overwrite an input", line.report.string());
}

void write_report(const fs::path& path, const std::string& text) {
    const fs::path temporary = temporary_for(path);
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    out << text;
    out.close();
    try {
        if (!out) throw model::Error(codes::kWriteFailed, "the report cannot be written", path.string());
        formats::publish_file(temporary, path);
    } catch (const model::Error&) {
        std::error_code ignored;
        fs::remove(temporary, ignored);
        throw;
    }
}

int print_plan(const BatchPlan& plan) {
    std::vector<AssetResult> results(plan.assets.size());
    for (std::size_t k = 0; k < plan.assets.size(); ++k) {
        const PlannedAsset& asset = plan.assets[k];
        results[k].error = asset.refusal;
        if (asset.refusal) say(stderr, failure_story(asset.source.string(), *asset.refusal));
        for (const fs::path& output : {asset.dgm, asset.exr})
            if (!asset.refusal && !output.empty())
                say(stdout, fmt::format("{} -> {}\n", printable(asset.source.string()),
                                        printable(output.lexically_normal().string())));
    }
    return static_cast<int>(worst_exit(results));
}

class Conversation {
 public:
    Conversation(const CommandLine& line, const BatchPlan& plan)
        : line_(line), plan_(plan), view_(line.quiet ? ProgressStyle::kNone : line.progress, names(plan)) {
        observer_.on_start = [this](std::size_t k) { view_.start(k); };
        observer_.on_progress = [this](std::size_t k, std::string_view stage, double share) {
            view_.update(k, printable(stage), share);
        };
        observer_.on_end = [this](std::size_t k) { view_.end(k); };
        observer_.on_finish = [this](std::size_t k, const AssetResult& result) { finished(k, result); };
        observer_.on_tick = [this] { view_.tick(); };
    }
    [[nodiscard]] const BatchObserver& observer() const { return observer_; }
    void end(const std::vector<AssetResult>& results) {
        view_.clear();
        if (worst_exit(results) == model::ExitCode::kInterrupted)
            say(stderr, failure_story({}, model::Error(codes::kInterrupted, summary_line(results))));
        else if (results.size() > 1 && !line_.quiet)
            say(stdout, summary_line(results) + '\n');
    }

 private:
    static std::vector<std::string> names(const BatchPlan& plan) {
        std::vector<std::string> out;
        for (const PlannedAsset& asset : plan.assets) out.push_back(printable(asset.source.filename().string()));
        return out;
    }
    void finished(std::size_t k, const AssetResult& result) {
        view_.clear();
        if (result.error)
            say(stderr, failure_story(plan_.assets[k].source.string(), *result.error, result.worker_output));
        if (result.outcome != Outcome::kBaked || line_.quiet) return;
        say(stdout, result_line(result) + '\n');
        if (result.report.search && !line_.verbose)
            say(stdout, "  " + search_story(*result.report.search, result.report.error.diagonal) + '\n');
        if (line_.verbose)
            for (const std::string& detail : detail_lines(result.report)) say(stdout, detail + '\n');
        std::fflush(stdout);
    }

    const CommandLine& line_;
    const BatchPlan& plan_;
    ProgressView view_;
    BatchObserver observer_;
};

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
    const BatchPlan plan = plan_batch(line.plan);
    check_files(line, plan);
    if (line.dry_run) return print_plan(plan);
    if (!line.report.empty()) check_writable(line.report);
    Conversation conversation(line, plan);
    const std::vector<AssetResult> results = run_batch(plan, line.bake, line.batch, conversation.observer());
    signals.batch_done();
    conversation.end(results);
    if (!line.report.empty())
        write_report(line.report, batch_report_json(plan, line.bake, line.batch, results, kGenerator));
    return static_cast<int>(worst_exit(results));
}

int run_command_line(int argc, const char* const* argv) {
    const auto line = parse_command_line(argc, argv);
    if (const Answer* answer = std::get_if<Answer>(&line)) {
        say(stdout, *answer);
        return static_cast<int>(model::ExitCode::kOk);
    }
    return run(std::get<CommandLine>(line));
}

}  // namespace

int bake_program(int argc, char** argv, const BakeFunction& bake) noexcept {
    model::Error failure(codes::kInternal, "unknown exception");
    try {
        if (is_worker(argc, argv)) return run_worker(bake);
        // A reader of our stdout that leaves (`| head`) must not leave temporaries behind.
        signal(SIGPIPE, SIG_IGN);
        const int exit_code = run_command_line(argc, argv);
        if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit_code;
        failure = model::Error(codes::kWriteFailed, "the results cannot be written to standard output");
    } catch (const model::Error& error) { failure = error; } catch (const std::bad_alloc&) {
        failure = model::Error(codes::kInternal, "out of memory");
    } catch (const std::exception& error) { failure = model::Error(codes::kInternal, error.what()); }
    say(stderr, failure_story(failure.place(), failure));
    return static_cast<int>(failure.code().exit);
}

}  // namespace dgm::bake
