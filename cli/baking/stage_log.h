// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/stage_log.h
// Runs stages: reports their progress, times them, and adds their names to errors.
#pragma once
#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "baking/attempt.h"
#include "baking/bake_options.h"
#include "baking/bake_report.h"
#include "baking/cpu_clock.h"
#include "model/progress.h"

namespace dgm::bake {

/// Calls `body`; an error that names no stage yet gets the name `stage`.
template <class Body>
auto in_stage(const std::string& stage, Body&& body) {
    try {
        return std::forward<Body>(body)();
    } catch (model::Error& error) {
        error.with_stage(stage);
        throw;
    }
}

/// The progress of part `k` of `count` equal parts of a stage. `whole` must outlive it. The search for a cut is the
/// long part of mapping: it is reported by its own name.
[[nodiscard]] model::Progress part_of(const model::Progress& whole, std::string stage, std::size_t k,
                                      std::size_t count);

class StageLog {
 public:
    /// `progress` must outlive it.
    explicit StageLog(const model::Progress& progress) : progress_(progress) {}
    StageLog(const StageLog&) = delete;
    StageLog& operator=(const StageLog&) = delete;

    /// body(progress), as the stage `name`.
    /// @throws model::Error kInterrupted, and the exceptions of `body`, with the stage's name
    template <class Body>
    auto run(std::string_view name, Body&& body) {
        const std::string shown = trial_ + std::string(name);
        progress_.update(shown, 0);
        const auto start = std::chrono::steady_clock::now();
        const CpuClock clock;
        auto result = in_stage(shown, [&] { return std::forward<Body>(body)(progress()); });
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        record(shown, seconds.count(), clock.seconds());
        return result;
    }

    /// body(trial), which runs stages for one grid of several and notes its measurements. The stages are shown as
    /// "129x129: map".
    template <class Body>
    Attempt<GridTrial> run_trial(GridSize size, Body&& body) {
        trial_ = std::to_string(size.rows) + "x" + std::to_string(size.cols) + ": ";
        Attempt<GridTrial> out = attempt([&] {
            const CpuClock clock;
            GridTrial trial = not_measured(size);
            body(trial);
            trial.cpu_seconds = clock.seconds();
            return trial;
        });
        trial_.clear();
        return out;
    }

    /// In the order run; a stage that ran several times in a row stands once.
    [[nodiscard]] const std::vector<StageTime>& times() const { return times_; }

 private:
    [[nodiscard]] model::Progress progress() const;
    void record(const std::string& shown, double seconds, double cpu_seconds);

    const model::Progress& progress_;
    std::string trial_;
    std::vector<StageTime> times_;
};

}  // namespace dgm::bake
