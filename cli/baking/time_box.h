// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/time_box.h
// Ends work that is worth only so much processor time.
#pragma once
#include <atomic>
#include <optional>
#include <string_view>
#include <utility>

#include "baking/attempt.h"
#include "baking/cpu_clock.h"
#include "model/progress.h"

namespace dgm::bake {

/// Runs pieces of work until all of them together have used `cpu_seconds` of the process. Only for what never decides a
/// byte of an output: how far the work comes depends on the machine.
class TimeBox {
 public:
    TimeBox(const model::Progress& outer, double cpu_seconds) : outer_(outer), cpu_seconds_(cpu_seconds) {}
    TimeBox(const TimeBox&) = delete;
    TimeBox& operator=(const TimeBox&) = delete;

    [[nodiscard]] bool spent() const { return clock_.seconds() > cpu_seconds_; }

    /// body(progress), or nullopt if the time was used up first. The body learns of it as of a request to stop.
    /// @throws model::Error kInterrupted if the outer progress asks to stop, and what body throws
    template <class Body>
    auto run(Body&& body) -> std::optional<decltype(body(std::declval<const model::Progress&>()))> {
        if (spent()) return std::nullopt;
        const model::Progress inner{[this](std::string_view stage, double share) {
                                        outer_.update(stage, share);
                                        // cppcheck-suppress identicalConditionAfterEarlyExit ; time has passed
                                        if (spent()) stop_ = true;
                                    },
                                    &stop_};
        try {
            return std::forward<Body>(body)(inner);
        } catch (const model::Error& error) {
            if (&error.code() != &model::codes::kInterrupted || !stop_) throw;
            return std::nullopt;
        }
    }

 private:
    const model::Progress& outer_;
    double cpu_seconds_;
    CpuClock clock_;
    std::atomic<bool> stop_ = false;
};

}  // namespace dgm::bake
