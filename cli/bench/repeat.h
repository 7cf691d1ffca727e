// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/repeat.h
// Runs the same work several times, to measure its time.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "batch/batch_runner.h"
#include "bench/statistics.h"

namespace dgm::bench {

struct BakeRepeats {
    unsigned repetitions = 4;
    unsigned jobs = 1;     ///< bakes at a time, each in a process of its own
    unsigned threads = 1;  ///< of one bake
    double time_limit_seconds = 600;
    std::uint64_t memory_bytes = std::uint64_t{8} << 30;
};

/// One thing to bake, and how often.
struct BakeTask {
    std::filesystem::path source;
    bake::BakeOptions options;
    unsigned repetitions = 1;
    double work = 1;  ///< of one bake, in any unit
};

/// Bakes tasks as dgm-bake does: in worker processes, files read back. `repeats.jobs` at a time, those with most work
/// first, so that no core waits long for the last one; repetitions of a task one after the other.
/// @param on_share  gets the share of the work that is done
/// @param on_task   gets the task that is begun; may be empty
/// @return for each task the results of its repetitions. The file of the first stays in `folder`; the others' are
///         removed, or a sweep would fill the disk.
/// @throws model::Error kInterrupted when a signal says so
[[nodiscard]] std::vector<std::vector<bake::AssetResult>> bake_all(
    const std::vector<BakeTask>& tasks, const BakeRepeats& repeats, const std::filesystem::path& folder,
    const std::function<void(double)>& on_share, const std::function<void(std::size_t)>& on_task = {});

/// The same for sources with the same options, each as often as asked. Results in the order of the sources, repetitions
/// of one together.
[[nodiscard]] std::vector<bake::AssetResult> bake_repeatedly(const std::vector<std::filesystem::path>& sources,
                                                             const bake::BakeOptions& options,
                                                             const BakeRepeats& repeats,
                                                             const std::filesystem::path& folder,
                                                             const std::function<void(double)>& on_share);

/// Figure of one quantity of those results that were baked.
[[nodiscard]] Figure figure_of(const std::vector<bake::AssetResult>& results,
                               const std::function<double(const bake::AssetResult&)>& quantity);

/// Wall seconds of one call of `body`: after a call to warm up, five times the mean of as many calls as fill 10 ms (at
/// least one).
[[nodiscard]] Figure time_of_call(const std::function<void()>& body);

}  // namespace dgm::bench
