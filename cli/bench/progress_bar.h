// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/progress_bar.h
#pragma once
#include <chrono>
#include <string>
#include <string_view>
#include <utility>

namespace dgm::bench {

/// One line on stderr that says how far a sweep is and how long it will take; redrawn on a terminal, else a line every
/// ten seconds. Nothing if `quiet`.
class ProgressBar {
 public:
    ProgressBar(bool quiet, double total_work);
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;
    ~ProgressBar() { clear(); }

    /// The next `work` (same unit as the total) is about `what`.
    void begin(std::string what, double work);
    /// The step begun last is at this now.
    void at(std::string what) { what_ = std::move(what); }
    /// Share of the step begun last, 0..1.
    void update(double share);
    /// Takes the bar off the screen, before other text is printed.
    void clear();
    /// A line for people, above the bar.
    void say(std::string_view line);

 private:
    using Clock = std::chrono::steady_clock;
    void show(bool now);

    bool quiet_, terminal_, drawn_ = false;
    double total_, done_ = 0, step_ = 0, share_ = 0;
    std::string what_;
    Clock::time_point started_ = Clock::now(), shown_;
};

}  // namespace dgm::bench
