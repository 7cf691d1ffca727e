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
#include "files/staging_folder.h"
#include "model/codes.h"
#include "process/signal_scope.h"
#include "worker/export_outputs.h"
#include "worker/output_files.h"
#include "worker/running_worker.h"
#include "worker/worker.h"
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

/// For an asset that is not up to date: why it is not baked all the same, if dgm-edit has painted its map. Which of the
/// map and the meshes beside it is old, only a look at the source would tell, and that is not the parent's to read. Nor
/// is it baked where the system fails for the moment and nobody knows.
std::optional<model::Error> keep_edits(const PlannedAsset& asset) try {
    for (const fs::path& map : {asset.dgm, asset.exr}) {
        if (map.empty()) continue;
        const std::vector<std::string> layers = edited_layers(map);
        if (layers.empty()) continue;
        const std::string names = fmt::format("{}", fmt::join(layers, ", "));
        if (asset.exports.empty())
            return model::Error(codes::kEditedMap, "the map is not up to date, but was edited since its bake: " + names,
                                map.string());
        return model::Error(codes::kEditedMap,
                            "the map was edited since its bake; it, or a mesh beside it, is not up to date: " + names,
                            map.string())
            .with_hint(
                fmt::format("if the mesh file has not changed, write what is beside the map anew: dgm-export {} -o {}",
                            map.string(), asset.exports[0].string()));
    }
    return std::nullopt;
} catch (const model::Error& error) { return error; }

/// Where a worker completes the outputs of an asset; goes away with all that was not published.
struct Staging {
    fs::path dgm, exr;
    std::vector<formats::StagingFolder> exports;  ///< one each
    std::vector<formats::StagingFolder> maps;     ///< of `dgm` and `exr`
};

/// One asset while its worker runs.
struct Running : RunningWorker {
    using RunningWorker::RunningWorker;
    std::size_t asset = 0;
    bool is_check = false;  ///< a copy of this program that looks whether the outputs are up to date
    Staging staging;
    std::uint64_t expected = 0;  ///< bytes at its peak
    std::string stage;
    std::size_t notices = 0;
    bool out_of_memory = false;
    std::optional<WorkerMessage> last_word;  ///< ResultMessage or ErrorMessage
};

/// A map keeps the name of its mesh, and a reader would take this one for a folder and a name: refused before the bake,
/// not after it.
void check_name(const fs::path& source) {
    if (source.filename().native().find('\\') == std::string::npos) return;
    throw model::Error(codes::kUnsupported, "the mesh's name has a backslash in it", source.string())
        .with_hint("rename the mesh: other systems separate folders by it");
}

/// @throws model::Error if an output cannot be put in place
Staging stage_outputs(const PlannedAsset& asset, OutputFolders& folders, const fs::path& root) {
    Staging out;
    const auto add = [&](const fs::path& final_path, std::vector<formats::StagingFolder>& to) {
        folders.make_below(root, final_path);
        check_place(final_path);
        return to.emplace_back(final_path, "no file can be created in the output folder").where(final_path.filename());
    };
    if (!asset.dgm.empty()) out.dgm = add(asset.dgm, out.maps);
    if (!asset.exr.empty()) out.exr = add(asset.exr, out.maps);
    for (const fs::path& output : asset.exports) static_cast<void>(add(output, out.exports));
    return out;
}

/// The files of a worker, meshes first and the map last: whoever sees the map may count on what goes with it.
std::vector<ExportedFile> written_files(const PlannedAsset& asset, const Staging& staging,
                                        const std::vector<fs::path>& inputs) {
    std::vector<ExportedFile> out;
    for (std::size_t k = asset.exports.size(); k-- > 0;)
        for (ExportedFile& file : exported_files(staging.exports[k].path(), asset.exports[k], inputs)) {
            // An OBJ and a PLY have the same texture.
            const auto same = [&](const ExportedFile& other) { return other.final_path == file.final_path; };
            if (std::none_of(out.begin(), out.end(), same)) out.push_back(std::move(file));
        }
    for (const auto& [temporary, final_path] :
         {std::pair(&staging.exr, &asset.exr), std::pair(&staging.dgm, &asset.dgm)}) {
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
    for (const ExportedFile& file : written_files(asset, r.staging, result.inputs)) {
        try {
            publish_output(file.temporary, file.final_path);
        } catch (const model::Error& failure) { throw explained(failure, file.temporary); }
        result.files.insert(result.files.begin(), OutputFile{file.final_path, file.bytes});
    }
}

/// Why there is no result.
std::optional<model::Error> error_of(const Running& r, std::uint64_t memory_bytes) {
    const ChildEnd end = r.end;
    if (r.verdict) return r.verdict;
    const bool has_result = r.last_word && std::holds_alternative<ResultMessage>(*r.last_word);
    if (has_result && end.signal == 0 && end.exit_code == 0) return std::nullopt;
    // Whatever a library made of a failed allocation, the shortage is the cause.
    if (r.out_of_memory) {
        const bool told = r.last_word && std::holds_alternative<ErrorMessage>(*r.last_word) &&
                          std::get<ErrorMessage>(*r.last_word).error.code().number == codes::kWorkerMemory.number;
        if (told) return std::get<ErrorMessage>(*r.last_word).error;
        return model::Error(codes::kWorkerMemory,
                            memory_bytes == 0
                                ? "the system ran out of memory"
                                : fmt::format("it needs more than the {} MiB it may take", memory_bytes >> 20));
    }
    if (end.is_killed())
        return model::Error(codes::kWorkerKilled,
                            fmt::format("the worker process was ended by signal {} ({}) from outside, as the "
                                        "system does where memory runs out",
                                        end.signal, strsignal(end.signal)));
    if (end.signal == SIGXCPU)
        return model::Error(codes::kWorkerTimeout,
                            fmt::format("it has used the processor time that it may (signal {})", end.signal));
    if (end.signal == 0 && r.last_word && !has_result) return std::get<ErrorMessage>(*r.last_word).error;
    return r.crash("result");
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
            while (can_start() && running_.size() < batch_.jobs && start_one()) {}
            signals_.wait(children_of(running_), false);
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
        return (next_ < plan_.assets.size() || !stale_.empty()) && !(batch_.stop_on_error && any_failed_);
    }

    /// Bakes what was found to be stale as soon as there is memory for it; else looks at the next asset.
    bool start_one() {
        if (stale_.empty()) {
            look_at(next_++);
            return true;
        }
        if (!has_memory(stale_.front())) return false;
        const std::size_t k = stale_.front();
        stale_.erase(stale_.begin());
        bake(k);
        return true;
    }

    [[nodiscard]] std::uint64_t expected_peak(std::size_t k) const {
        const std::uint64_t peak = estimate_peak(plan_.assets[k].source, plan_.assets[k].options);
        return batch_.memory_bytes != 0 ? std::min(peak, batch_.memory_bytes) : peak;
    }

    /// True if the next asset fits beside those that run, when they have grown as far as they are expected to.
    [[nodiscard]] bool has_memory(std::size_t k) {
        if (running_.empty()) return true;
        if (estimated_ != k) {
            estimate_ = expected_peak(k);  // asked again and again while it waits
            estimated_ = k;
        }
        const std::uint64_t available = available_memory();
        if (available == 0) return true;
        std::uint64_t needed = estimate_;
        for (const Running& r : running_) needed += r.expected - std::min(r.expected, resident_memory(r.child.pid()));
        return needed <= available;
    }

    /// Nothing to do where the same bytes would be written again. To find that out takes reading whatever the mesh
    /// names: it is done apart, in the asset's own time.
    void look_at(std::size_t k) {
        const PlannedAsset& asset = plan_.assets[k];
        if (asset.refusal) return fail(k, *asset.refusal);
        const std::vector<fs::path> outputs = outputs_of(asset);
        std::error_code ignored;
        const bool all_there = !outputs.empty() && std::all_of(outputs.begin(), outputs.end(), [&](const fs::path& p) {
            return fs::is_regular_file(p, ignored);
        });
        if (batch_.force || !all_there) return stale_.push_back(k);
        const OutputCheck check{asset.source, outputs, asset.options, batch_.memory_bytes, wants_inputs(asset)};
        try {
            Running& r = running_.emplace_back(std::function<void()>([check] { send_if_up_to_date(check); }));
            r.asset = k;
            r.is_check = true;
        } catch (const model::Error& error) { fail(k, error); }
    }

    [[nodiscard]] bool wants_inputs(const PlannedAsset& asset) const {
        return batch_.wants_inputs || !asset.exports.empty();
    }

    void end_check(Running& r) {
        const PlannedAsset& asset = plan_.assets[r.asset];
        AssetResult& result = results_[r.asset];
        if (r.verdict && r.verdict->code().number == codes::kWorkerTimeout.number) {
            r.verdict->with_stage("look whether it is up to date");
            return fail(r.asset, std::move(*r.verdict));
        }
        // Whatever else became of it, the bake will report the fault.
        if (r.verdict || !r.last_word || !std::holds_alternative<ResultMessage>(*r.last_word))
            return stale_.push_back(r.asset);
        for (const fs::path& output : outputs_of(asset)) {
            std::error_code ignored;
            result.files.push_back({output, output_bytes(output, output == asset.exr, ignored)});
        }
        take_result(r, result);
        result.outcome = Outcome::kUpToDate;
        mark_ended(r.asset);
    }

    static void take_result(Running& r, AssetResult& result) {
        auto& message = std::get<ResultMessage>(*r.last_word);
        result.report = std::move(message.report);
        result.inputs = std::move(message.inputs);
    }

    void bake(std::size_t k) {
        const PlannedAsset& asset = plan_.assets[k];
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
        // Only where the clock of time_limit_seconds fails: threads that wait for others take some time, too.
        job.cpu_seconds = static_cast<std::uint32_t>(std::min(60 + batch_.time_limit_seconds * (threads_ + 1.0), 4e9));
        job.wants_inputs = wants_inputs(asset);
        try {
            check_name(asset.source);
            Staging staging = stage_outputs(asset, folders_, plan_.folder);
            job.dgm = staging.dgm;
            job.exr = staging.exr;
            for (std::size_t e = 0; e < asset.exports.size(); ++e)
                job.exports.push_back(staging.exports[e].where(asset.exports[e].filename()));
            const std::uint64_t expected = expected_peak(k);
            Running& r = running_.emplace_back(encode(job));
            r.asset = k;
            r.staging = std::move(staging);
            r.expected = expected;
        } catch (const model::Error& error) { fail(k, error); }
    }

    /// Takes what a worker has sent; true if it is through and its result stands.
    bool advance(Running& r) {
        if (!r.advance(batch_.time_limit_seconds, [&](const std::string& line) { return take(r, line); })) return false;
        if (r.is_check)
            end_check(r);
        else
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
        std::optional<model::Error> error = error_of(r, batch_.memory_bytes);
        if (!error) {
            try {
                take_result(r, result);
                publish(plan_.assets[r.asset], r, result);
            } catch (const model::Error& failure) {
                error = failure;
                error->with_stage("write");
            }
        }
        if (error) {
            error->with_stage(r.stage);
            fail(r.asset, std::move(*error));
        } else {
            result.outcome = Outcome::kBaked;
            mark_ended(r.asset);
        }
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
        for (const Running& r : running_) results_[r.asset].outcome = Outcome::kInterrupted;
        running_.clear();
        for (const std::size_t k : stale_) results_[k].outcome = Outcome::kInterrupted;
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
    bool any_failed_ = false;
    std::vector<std::size_t> stale_;  ///< to be baked, in their order
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
