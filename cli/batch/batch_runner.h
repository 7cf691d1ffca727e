// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/batch_runner.h
// Bakes the assets of a plan, each in a worker process of its own, several at a time.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baking/bake_options.h"
#include "baking/bake_report.h"
#include "batch/batch_plan.h"
#include "model/error.h"

namespace dgm::bake {

struct BatchOptions {
    unsigned jobs = 1;                                    ///< worker processes at a time; >= 1
    double time_limit_seconds = 600;                      ///< wall clock of one asset; > 0
    std::uint64_t memory_bytes = std::uint64_t{8} << 30;  ///< address space of one worker; 0: no limit
    unsigned threads = 0;                                 ///< of one worker; 0: the cores, shared out among `jobs`
    bool stop_on_error = false;                           ///< start nothing new after an asset that was not baked
    bool shares_folders = false;                          ///< others bake into the output folder at the same time
    bool force = false;                                   ///< bake what is up to date or was edited, too
    bool wants_inputs = false;                            ///< results say which files were read
};

enum class Outcome { kBaked, kUpToDate, kRefused, kFailed, kInterrupted, kNotStarted };

inline constexpr std::array kOutcomes{Outcome::kBaked,  Outcome::kUpToDate,    Outcome::kRefused,
                                      Outcome::kFailed, Outcome::kInterrupted, Outcome::kNotStarted};

/// "baked", "up to date", "refused", "failed", "interrupted", "not started".
[[nodiscard]] std::string_view name_of(Outcome outcome);

struct OutputFile {
    std::filesystem::path path;
    std::uint64_t bytes = 0;
};

struct AssetResult {
    Outcome outcome = Outcome::kNotStarted;
    std::vector<OutputFile> files;              ///< kBaked: what was put in place; kUpToDate: what was there
    BakeReport report;                          ///< kBaked; kUpToDate: as it was stored, without times
    std::optional<model::Error> error;          ///< kRefused, kFailed
    std::vector<std::filesystem::path> inputs;  ///< every file that was read; with BatchOptions::wants_inputs
    std::string worker_output;                  ///< last lines the worker wrote on stderr; for crashes
    double seconds = 0;                         ///< wall clock
};

/// Told about the batch while it runs; all called from the thread of run_batch, any may be empty.
struct BatchObserver {
    std::function<void(std::size_t asset)> on_start;
    std::function<void(std::size_t asset, std::string_view stage, double share)> on_progress;
    /// A line of plain language about the mesh, before the long part begins.
    std::function<void(std::size_t asset, const Notice& notice)> on_notice;
    /// Its worker is gone. on_finish may wait for earlier assets.
    std::function<void(std::size_t asset, const AssetResult& result)> on_end;
    /// In the order of the plan, whatever order the workers end in.
    std::function<void(std::size_t asset, const AssetResult& result)> on_finish;
    std::function<void()> on_tick;  ///< at least four times a second
};

/// Runs the whole batch, each asset with the options of the plan. Outputs that are up to date (up_to_date.h) stay; a
/// map that is not, and that somebody has edited, stays too and its asset is refused (kEditedMap). A worker is started
/// only while its estimated peak fits beside what the others may still take (memory_budget.h); one runs always. One
/// result for each asset of the plan, in its order; what goes wrong with an asset is in its result and never an
/// exception. Outputs appear whole or not at all; no temporary file is left. On SIGINT, SIGTERM or SIGHUP the workers
/// are killed and the rest of the batch is kInterrupted; the signals' handlers are restored at the end. The same
/// outputs whatever the number of jobs.
/// @throws model::Error kWriteFailed if the output folder cannot be made
[[nodiscard]] std::vector<AssetResult> run_batch(const BatchPlan& plan, const BatchOptions& batch,
                                                 const BatchObserver& observer);

/// The batch's exit code is that of its worst asset, worst first: interrupted (130), transient (75), internal (4), I/O
/// (2), invalid (3), unsupported (5), ok (0). So a script sees a crash even where other meshes were only refused, and
/// that running it again is worth while even where something else is wrong for good.
[[nodiscard]] model::ExitCode worst_exit(const std::vector<AssetResult>& results);

}  // namespace dgm::bake
