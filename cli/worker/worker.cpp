// SPDX-License-Identifier: GPL-3.0-or-later
// cli/worker/worker.cpp
#include "worker/worker.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <new>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "baking/up_to_date.h"
#include "dgm/dgm_reader.h"
#include "exr/exr_reader.h"
#include "model/codes.h"
#include "model/shortage.h"
#include "process/sandbox.h"
#include "worker/export_outputs.h"
#include "worker/output_files.h"
#include "worker/worker_protocol.h"

namespace dgm::bake {
namespace {

namespace codes = model::codes;

/// Sends progress at most ten times a second, and each new stage.
class ProgressSender {
 public:
    void operator()(std::string_view stage, double share) {
        const auto now = std::chrono::steady_clock::now();
        if (stage == stage_ && now - sent_ < std::chrono::milliseconds(100)) return;
        stage_ = stage;
        sent_ = now;
        static_cast<void>(send_message(
            encode(WorkerMessage{ProgressMessage{stage_, std::isfinite(share) ? std::clamp(share, 0.0, 1.0) : 0.0}})));
    }
    [[nodiscard]] const std::string& stage() const { return stage_; }

 private:
    std::string stage_;
    std::chrono::steady_clock::time_point sent_;
};

void add_resource_use(BakeReport& report) {
    rusage use{};
    if (getrusage(RUSAGE_SELF, &use) != 0) return;
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    report.cpu_seconds = seconds(use.ru_utime) + seconds(use.ru_stime);
    report.peak_memory_bytes = static_cast<std::uint64_t>(use.ru_maxrss) * 1024;
}

BakeReport bake_and_write(const WorkerJob& job, const BakeFunction& bake, ProgressSender& sender) {
    model::Progress progress;
    progress.on_update = [&](std::string_view stage, double share) { sender(stage, share); };
    progress.update("import", 0);
    BakeResult result = bake(job.source, job.options, progress);
    const auto start = std::chrono::steady_clock::now();
    progress.update("write", 0);
    if (job.options.write_dgm) write_verified(job.dgm, result.maps, OutputFormat::kDgm, job.options.exr_layout);
    progress.update("write", 0.5);
    if (job.options.write_exr) write_verified(job.exr, result.maps, OutputFormat::kExr, job.options.exr_layout);
    write_exports(result.maps, job.exports);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    result.report.times.push_back({"write", taken.count()});
    add_resource_use(result.report);
    return std::move(result.report);
}

/// Result of `work`, or its failure.
template <class Work>
WorkerMessage guarded(std::uint64_t memory_bytes, const ProgressSender& sender, const Work& work) {
    std::optional<model::Error> failure;
    try {
        return work();
    } catch (const model::Error& error) { failure = error; } catch (const std::bad_alloc&) {
        failure.emplace(codes::kWorkerMemory,
                        memory_bytes == 0
                            ? "an allocation failed"
                            : fmt::format("it needs more than the {} MiB it may take", memory_bytes >> 20));
    } catch (const std::exception& other) { failure = model::error_of(other); }
    failure->with_stage(sender.stage());
    return ErrorMessage{*failure};
}

WorkerMessage outcome_of(WorkerJob job, const BakeFunction& bake) {
    std::vector<std::filesystem::path> outputs = job.exports;
    outputs.insert(outputs.end(), {job.dgm, job.exr});
    std::vector<std::filesystem::path> readable = job.options.asset_roots;
    if (!job.options.texture.empty()) readable.push_back(job.options.texture);
    Sandbox sandbox = worker_sandbox(job.source, std::move(readable), outputs);
    sandbox.cpu_seconds = job.cpu_seconds;
    static_cast<void>(enter_sandbox(sandbox));
    ProgressSender sender;
    job.options.on_notice = [](const Notice& notice) {
        static_cast<void>(send_message(encode(WorkerMessage{NoticeMessage{notice}})));
    };
    return guarded(job.memory_bytes, sender, [&]() -> WorkerMessage {
        ResultMessage result{bake_and_write(job, bake, sender), {}};
        if (job.wants_inputs) result.inputs = input_files(job.source, job.options, result.report);
        return result;
    });
}

/// The result of a page is its file: the report in the message is empty.
WorkerMessage outcome_of_page(std::string_view job, std::uint64_t memory_bytes, const PageFunction& page) {
    return guarded(memory_bytes, {}, [&]() -> WorkerMessage {
        page(job);
        return ResultMessage{};
    });
}

}  // namespace

void send_if_up_to_date(const OutputCheck& check) {
    limit_worker_memory(check.memory_bytes, 1);
    std::vector<std::filesystem::path> readable = check.options.asset_roots;
    if (!check.options.texture.empty()) readable.push_back(check.options.texture);
    for (const std::filesystem::path& output : check.outputs)
        readable.push_back(output.has_parent_path() ? output.parent_path() : ".");
    Sandbox sandbox = import_sandbox(check.source, std::move(readable));
    sandbox.cpu_seconds = 0;
    static_cast<void>(enter_sandbox(sandbox));
    // A crash costs this process alone.
    formats::set_hdf5_reader({});
    formats::set_exr_reader({});
    std::optional<BakeReport> report = up_to_date(check.source, check.outputs, check.options);
    if (!report) return;
    ResultMessage result{std::move(*report), {}};
    if (check.wants_inputs) result.inputs = input_files(check.source, check.options, result.report);
    static_cast<void>(send_message(encode(WorkerMessage{std::move(result)})));
}

int run_worker(const BakeFunction& bake, const PageFunction& page) {
    if (!has_message_descriptor()) return static_cast<int>(model::ExitCode::kUsage);
    WorkerMessage outcome = OutOfMemoryMessage{};
    try {
        const std::string text = read_job_text();
        const JobLimits limits = decode_limits(text);
        limit_worker_memory(limits.memory_bytes, limits.threads);
        const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, std::max(1U, limits.threads));
        outcome = page && is_page_job(text) ? outcome_of_page(text, limits.memory_bytes, page)
                                            : outcome_of(decode_job(text), bake);
    } catch (const model::Error& error) { outcome = ErrorMessage{error}; } catch (const std::bad_alloc&) {
    }  // said so
    if (!send_message(encode(outcome))) return static_cast<int>(model::ExitCode::kInternal);
    // Destructors of statics in the libraries have crashed after a good bake before; there is nothing left to save.
    std::fflush(nullptr);
    _exit(static_cast<int>(model::ExitCode::kOk));
}

}  // namespace dgm::bake
