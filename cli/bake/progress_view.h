// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bake/progress_view.h
// Where a batch is, on stderr: a bar that redraws itself on a terminal, else a line now and then.
#pragma once
#include <chrono>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "bake/options.h"

namespace dgm::bake {

class ProgressView {
 public:
    /// `names`: what to call each asset; `weights`: about what share of the work each is, in any unit. kAuto looks at
    /// stderr.
    ProgressView(ProgressStyle style, std::vector<std::string> names, std::vector<double> weights);
    ProgressView(const ProgressView&) = delete;
    ProgressView& operator=(const ProgressView&) = delete;
    ~ProgressView() { clear(); }

    void start(std::size_t asset);
    void update(std::size_t asset, std::string_view stage, double share);
    /// One that was never started took no time, and says nothing about the time of others.
    void end(std::size_t asset);
    /// Redraws the bar, at most ten times a second.
    void tick();
    /// Takes the bar off the screen, before other text is printed.
    void clear();

 private:
    using Clock = std::chrono::steady_clock;
    struct Active {
        std::string stage;
        double share = 0;        ///< of the stage
        double done = 0;         ///< of the asset
        Clock::time_point said;  ///< plain: when its last line was printed
    };
    [[nodiscard]] std::string bar_line(std::size_t columns) const;
    /// ", 2:10 to go", or nothing as long as it is unknown.
    [[nodiscard]] std::string to_go() const;

    ProgressStyle style_;
    std::vector<std::string> names_;
    std::map<std::size_t, Active> active_;
    std::vector<double> weights_;
    double total_ = 0, done_ = 0;  ///< weights: of all that take time, and of those that are through
    std::size_t ended_ = 0;
    Clock::time_point begun_ = Clock::now(), drawn_;
    bool on_screen_ = false;
};

}  // namespace dgm::bake
