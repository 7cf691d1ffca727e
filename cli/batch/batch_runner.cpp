// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/batch_runner.cpp
#include "batch/batch_runner.h"

#include <fmt/format.h>
#include <signal.h>
#include <string.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <list>
#include <thread>

#include "baking/up_to_date.h"
#include "batch/memory_budget.h"
#include "model/codes.h"
#include "process/signal_scope.h"
#include "worker/export_outputs.h"
#include "worker/output_files.h"
#include "worker/running_worker.h"
#include "worker/worker_protocol.h"

namespace dgm::bake {
namespace {

namespace fs = std::filesystem;
namespace codes = model::codes;
using Clock = std::chrono::steady_clock;

/// A mesh may have thousands of faults; nobody reads more than some.
constexpr std::size_t kMaxNotices = 20, kMaxNoticeBytes = 400;

Outcome outcome_of(const model::Error& error) {
    const int number = error.code().number;
    const bool about_the_mesh = number / 1000 == 3 || error.code().exit == model::ExitCode::kUnsupported;
    return about_the_mesh || number == codes::kEditedMap.number ? Outcome::kRefused : Outcome::kFailed;
}

/// For an asset that is not up to date: why it is not baked all the same, if dgm-edit has painted its map.
std::optional<model::Error> keep_edits(const PlannedAsset& asset) {
    std::vector<fs::path> maps;
    for (const fs::path& map : {asset.dgm, asset.exr})
        if (!map.empty()) maps.push_back(map);
    for (const fs::path& map : maps) {
        const std::vector<std::string> layers = edited_layers(map);
        if (layers.empty()) continue;
        const std::string names = fmt::format("{}", fmt::join(layers, ", "));
        if (asset.exports.empty() || !up_to_date(asset.source, maps, asset.options))
            return model::Error(codes::kEditedMap, "the map is not up to date, but was edited since its bake: " + names,
                                map.string());
        return model::Error(codes::kEditedMap, "the map was edited, and a mesh beside it does not show that: " + names,
                            map.string())
            .with_hint(
                fmt::format("write the mesh anew: dgm-export {} -o {}", map.string(), asset.exports[0].string()));
    }
    return std::nullopt;
}

/// One asset while its worker runs.
struct Running : RunningWorker {
    using RunningWorker::RunningWorker;
    std::size_t asset = 0;
    fs::path dgm, exr;              ///< temporary names
    std::vector<fs::path> folders;  ///< temporary, of each export
    std::uint64_t expected = 0;     ///< bytes at its peak
    std::string stage;
    std::size_t notices = 0;
    bool out_of_memory = false;
    std::optional<WorkerMessage> last_word;  ///< ResultMessage or ErrorMessage
};

void remove_folders(const std::vector<fs::path>& folders) {
    std::error_code ignored;
    for (const fs::path& folder : folders) fs::remove_all(folder, ignored);
}

void remove_temporaries(const Running& r) {
    for (const fs::path& file : {r.dgm, r.exr})  // published ones are gone
        if (!file.empty()) remove_output(file);
    remove_folders(r.folders);
}

/// The files of a worker, meshes first and the map last: whoever sees the map may count on what goes with it.
std::vector<ExportedFile> written_files(const PlannedAsset& asset, const Running& r, const BakeReport& report) {
    std::vector<ExportedFile> out;
    const std::vector<fs::path> inputs =
        asset.exports.empty() ? asset.exports : input_files(asset.source, asset.options, report);
    for (std::size_t k = asset.exports.size(); k-- > 0;)
        for (ExportedFile& file : exported_files(r.folders[k], asset.exports[k], inputs)) {
            // An OBJ and a PLY have the same texture.
            const auto same = [&](const ExportedFile& other) { return other.final_path == file.final_path; };
            if (std::none_of(out.begin(), out.end(), same)) out.push_back(std::move(file));
        }
    for (const auto& [temporary, final_path] : {std::pair(&r.exr, &asset.exr), std::pair(&r.dgm, &asset.dgm)}) {
        if (temporary->empty()) continue;
        std::error_code error;
        out.push_back({*temporary, *final_path, output_bytes(*temporary, final_path == &asset.exr, error)});
        if (error)
            throw model::Error(codes::kWriteFailed, "the written file is gone: " + error.message(),
                               final_path->string());
    }
    return out;
}

void publish(const PlannedAsset& asset, const Running& r, AssetResult& result) {
    for (const ExportedFile& file : written_files(asset, r, result.report)) {
        try {
            publish_output(file.temporary, file.final_path);
        } catch (const model::Error& failure) { throw explained(failure, file.temporary); }
        result.files.insert(result.files.begin(), OutputFile{file.final_path, file.bytes});
    }
}

class Batch {
 public:
    Batch(const BatchPlan& plan, const BatchOptions& batch, const BatchObserver& observer)
        : plan_(plan),
          batch_(batch),
          observer_(observer),
          results_(plan.assets.size()),
          folders_(batch.shares_folders) {
        const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
        const auto at_once = static_cast<unsigned>(std::clamp<std::size_t>(plan.assets.size(), 1, batch.jobs));
        threads_ = batch.threads > 0 ? batch.threads : std::max(1U, cores / at_once);
    }

    std::vector<AssetResult> run() {
        const bool any_outputs =
            std::any_of(plan_.assets.begin(), plan_.assets.end(), [](const PlannedAsset& a) { return !a.refusal; });
        if (any_outputs) folders_.make(plan_.folder);
        while (!signals_.stop_requested() && (can_start() || !running_.empty())) {
            skipped_ = false;  // after each one that is up to date, signals are heard and results are told
            while (can_start() && running_.size() < batch_.jobs && !skipped_ && has_memory()) start(next_++);
            signals_.wait(children_of(running_), skipped_);
            for (auto it = running_.begin(); it != running_.end();)
                it = advance(*it) ? running_.erase(it) : std::next(it);
            report_finished();
            if (observer_.on_tick) observer_.on_tick();
        }
        if (signals_.stop_requested()) interrupt();
        done_.assign(results_.size(), true);
        report_finished();
        return std::move(results_);
    }

 private:
    [[nodiscard]] bool can_start() const {
        return next_ < plan_.assets.size() && !(batch_.stop_on_error && any_failed_);
    }

    [[nodiscard]] std::uint64_t expected_peak(std::size_t k) const {
        const std::uint64_t peak = estimate_peak(plan_.assets[k].source, plan_.assets[k].options);
        return batch_.memory_bytes != 0 ? std::min(peak, batch_.memory_bytes) : peak;
    }

    /// True if the next asset fits beside those that run, when they have grown as far as they are expected to.
    [[nodiscard]] bool has_memory() {
        if (running_.empty()) return true;
        if (estimated_ != next_) {
            estimate_ = expected_peak(next_);  // asked again and again while it waits
            estimated_ = next_;
        }
        const std::uint64_t available = available_memory();
        if (available == 0) return true;
        std::uint64_t needed = estimate_;
        for (const Running& r : running_) needed += r.expected - std::min(r.expected, resident_memory(r.child.pid()));
        return needed <= available;
    }

    /// Nothing to do where the same bytes would be written again.
    bool skip(std::size_t k) {
        const PlannedAsset& asset = plan_.assets[k];
        const std::vector<fs::path> outputs = outputs_of(asset);
        if (batch_.force || outputs.empty()) return false;
        std::optional<BakeReport> report = up_to_date(asset.source, outputs, asset.options);
        if (!report) return false;
        AssetResult& result = results_[k];
        for (const fs::path& output : outputs) {
            std::error_code ignored;
            result.files.push_back({output, output_bytes(output, output == asset.exr, ignored)});
        }
        result.report = std::move(*report);
        result.outcome = Outcome::kUpToDate;
        skipped_ = true;
        mark_ended(k);
        return true;
    }

    void start(std::size_t k) {
        const PlannedAsset& asset = plan_.assets[k];
        if (asset.refusal) return fail(k, *asset.refusal);
        if (skip(k)) return;
        if (!batch_.force)
            if (std::optional<model::Error> edited = keep_edits(asset)) return fail(k, std::move(*edited));
        if (std::optional<model::Error> too_large = refuse_size(asset.options, batch_.memory_bytes))
            return fail(k, std::move(*too_large));
        if (observer_.on_start) observer_.on_start(k);
        WorkerJob job;
        job.source = asset.source;
        job.options = asset.options;
        job.memory_bytes = batch_.memory_bytes;
        job.threads = threads_;
        std::vector<fs::path> folders;
        try {
            for (const auto& [final_path, temporary] :
                 {std::pair(&asset.dgm, &job.dgm), std::pair(&asset.exr, &job.exr)}) {
                if (final_path->empty()) continue;
                folders_.make_below(plan_.folder, *final_path);
                check_writable(*final_path);
                *temporary = temporary_for(*final_path);
            }
            for (const fs::path& output : asset.exports) {
                folders_.make_below(plan_.folder, output);
                check_writable(output);
                folders.push_back(make_export_folder(output));
                job.exports.push_back(folders.back() / output.filename());
            }
            const std::uint64_t expected = expected_peak(k);
            Running& r = running_.emplace_back(encode(job));
            r.asset = k;
            r.dgm = job.dgm;
            r.exr = job.exr;
            r.folders = std::move(folders);
            r.expected = expected;
        } catch (const model::Error& error) {
            remove_folders(folders);
            fail(k, error);
        }
    }

    /// Takes what a worker has sent; true if it is through and its result stands.
    bool advance(Running& r) {
        if (!r.advance(batch_.time_limit_seconds, [&](const std::string& line) { return take(r, line); })) return false;
        finish(r);
        return true;
    }

    bool take(Running& r, const std::string& line) {
        std::optional<WorkerMessage> message = decode_message(line);
        if (!message || r.last_word) return false;
        if (const auto* progress = std::get_if<ProgressMessage>(&*message)) {
            r.stage = progress->stage.substr(0, 64);
            if (observer_.on_progress) observer_.on_progress(r.asset, r.stage, progress->share);
        } else if (const auto* notice = std::get_if<NoticeMessage>(&*message)) {
            if (r.notices++ < kMaxNotices && observer_.on_notice)
                observer_.on_notice(r.asset, {notice->notice.kind.substr(0, kMaxNoticeBytes),
                                              notice->notice.text.substr(0, kMaxNoticeBytes)});
        } else if (std::holds_alternative<OutOfMemoryMessage>(*message)) {
            r.out_of_memory = true;
        } else {
            r.last_word = std::move(message);
        }
        return true;
    }

    void finish(Running& r) {
        AssetResult& result = results_[r.asset];
        result.seconds = std::chrono::duration<double>(Clock::now() - r.started).count();
        result.worker_output = r.child.error_text();
        std::optional<model::Error> error = error_of(r);
        if (!error) {
            try {
                result.report = std::move(std::get<ResultMessage>(*r.last_word).report);
                publish(plan_.assets[r.asset], r, result);
            } catch (const model::Error& failure) {
                error = failure;
                error->with_stage("write");
            }
        }
        remove_temporaries(r);
        if (error) {
            error->with_stage(r.stage);
            fail(r.asset, std::move(*error));
        } else {
            result.outcome = Outcome::kBaked;
            mark_ended(r.asset);
        }
    }

    [[nodiscard]] std::optional<model::Error> error_of(const Running& r) const {
        const ChildEnd end = r.end;
        if (r.verdict) return r.verdict;
        const bool has_result = r.last_word && std::holds_alternative<ResultMessage>(*r.last_word);
        if (has_result && end.signal == 0 && end.exit_code == 0) return std::nullopt;
        // Whatever a library made of a failed allocation, the shortage is the cause.
        if (r.out_of_memory) {
            const bool told = r.last_word && std::holds_alternative<ErrorMessage>(*r.last_word) &&
                              std::get<ErrorMessage>(*r.last_word).error.code().number == codes::kWorkerMemory.number;
            if (told) return std::get<ErrorMessage>(*r.last_word).error;
            return model::Error(codes::kWorkerMemory, batch_.memory_bytes == 0
                                                          ? "the system ran out of memory"
                                                          : fmt::format("it needs more than the {} MiB it may take",
                                                                        batch_.memory_bytes >> 20));
        }
        // Not by us, and not by itself: the kernel where memory ran out, a scheduler, or a person.
        if (end.signal == SIGKILL || end.signal == SIGTERM)
            return model::Error(codes::kWorkerKilled,
                                fmt::format("the worker process was ended by signal {} ({}) from outside, as the "
                                            "system does where memory runs out",
                                            end.signal, strsignal(end.signal)));
        if (end.signal == 0 && r.last_word && !has_result) return std::get<ErrorMessage>(*r.last_word).error;
        return r.crash("result");
    }

    void fail(std::size_t k, model::Error error) {
        results_[k].outcome = outcome_of(error);
        results_[k].error = std::move(error);
        results_[k].files.clear();
        any_failed_ = true;
        mark_ended(k);
    }

    void mark_ended(std::size_t k) {
        done_[k] = true;
        if (observer_.on_end) observer_.on_end(k, results_[k]);
    }

    void interrupt() {
        kill_all(running_);
        for (const Running& r : running_) {
            remove_temporaries(r);
            results_[r.asset].outcome = Outcome::kInterrupted;
        }
        running_.clear();
        for (; next_ < results_.size(); ++next_) results_[next_].outcome = Outcome::kInterrupted;
    }

    void report_finished() {
        for (; reported_ < results_.size() && done_[reported_]; ++reported_)
            if (observer_.on_finish) observer_.on_finish(reported_, results_[reported_]);
    }

    const BatchPlan& plan_;
    const BatchOptions& batch_;
    const BatchObserver& observer_;
    std::vector<AssetResult> results_;
    std::vector<bool> done_ = std::vector<bool>(results_.size());
    std::size_t next_ = 0, reported_ = 0;
    bool any_failed_ = false, skipped_ = false;
    unsigned threads_ = 1;
    std::uint64_t estimate_ = 0;  ///< of asset `estimated_`
    std::size_t estimated_ = std::numeric_limits<std::size_t>::max();
    OutputFolders folders_;
    SignalScope signals_;
    std::list<Running> running_;  ///< last: its workers are killed before the folders are cleared
};

}  // namespace

std::string_view name_of(Outcome outcome) {
    switch (outcome) {
        case Outcome::kBaked:
            return "baked";
        case Outcome::kUpToDate:
            return "up to date";
        case Outcome::kRefused:
            return "refused";
        case Outcome::kFailed:
            return "failed";
        case Outcome::kInterrupted:
            return "interrupted";
        case Outcome::kNotStarted:
            return "not started";
    }
    return {};
}

std::vector<AssetResult> run_batch(const BatchPlan& plan, const BatchOptions& batch, const BatchObserver& observer) {
    return Batch(plan, batch, observer).run();
}

model::ExitCode worst_exit(const std::vector<AssetResult>& results) {
    model::ExitCode worst = model::ExitCode::kOk;
    for (const AssetResult& result : results) {
        model::ExitCode exit = model::ExitCode::kOk;
        if (result.outcome == Outcome::kInterrupted) exit = model::ExitCode::kInterrupted;
        if (result.error) exit = result.error->code().exit;
        worst = model::worse(worst, exit);
    }
    return worst;
}

}  // namespace dgm::bake
