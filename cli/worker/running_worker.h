// SPDX-License-Identifier: GPL-3.0-or-later
// cli/worker/running_worker.h
// One worker process while it runs, whatever its job: what came of it, and the end of all when a signal says so.
// Whoever derives from it adds what the job is about.
#pragma once
#include <chrono>
#include <functional>
#include <list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/error.h"
#include "process/child_process.h"

namespace dgm::bake {

struct RunningWorker {
    using Clock = std::chrono::steady_clock;

    ChildProcess child;
    Clock::time_point started = Clock::now();
    std::optional<model::Error> verdict;  ///< set by us, who then killed it: out of time, or it sent nonsense
    ChildEnd end;                         ///< how it ended by itself

    /// @throws model::Error as ChildProcess
    explicit RunningWorker(std::string_view job) : child(job) {}
    explicit RunningWorker(const std::function<void()>& work) : child(work) {}

    /// Hands each message line to `take`, which returns false for one that is no message. True if the worker is
    /// through: it has ended with all it sent taken, or was killed for the verdict. Does not wait.
    [[nodiscard]] bool advance(double time_limit_seconds, const std::function<bool(const std::string& line)>& take);

    /// The error of a worker that ended without its result: "... ended with exit code 1 and no page", or by a signal.
    [[nodiscard]] model::Error crash(std::string_view missing) const;
};

/// For SignalScope::wait().
template <class Running>
[[nodiscard]] std::vector<const ChildProcess*> children_of(const std::list<Running>& running) {
    std::vector<const ChildProcess*> out;
    for (const RunningWorker& worker : running) out.push_back(&worker.child);
    return out;
}

/// Kills them all, then waits half a second for their ends: an interrupted program ends within a second, workers with
/// gigabytes to give back on a busy machine or not.
template <class Running>
void kill_all(std::list<Running>& running) {
    for (RunningWorker& worker : running) worker.child.begin_kill();
    const auto deadline = RunningWorker::Clock::now() + std::chrono::milliseconds(500);
    for (RunningWorker& worker : running) worker.child.leave(deadline);
}

}  // namespace dgm::bake
