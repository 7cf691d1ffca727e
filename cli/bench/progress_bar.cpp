// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/progress_bar.cpp
#include "bench/progress_bar.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "model/printable.h"
#include "tool/minutes.h"

namespace dgm::bench {
namespace {

constexpr auto kRedraw = std::chrono::milliseconds(100);
constexpr auto kPlainPause = std::chrono::seconds(10);
constexpr int kBarWidth = 24;
constexpr double kFirstGuess = 0.03;  ///< share of the work after which the time left can be guessed

}  // namespace

ProgressBar::ProgressBar(bool quiet, double total_work)
    : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0), total_(std::max(total_work, 1e-9)) {}

void ProgressBar::begin(std::string what, double work) {
    done_ += step_;
    step_ = work;
    share_ = 0;
    what_ = std::move(what);
    show(terminal_);
}

void ProgressBar::update(double share) {
    share_ = std::clamp(share, share_, 1.0);
    show(false);
}

void ProgressBar::clear() {
    if (drawn_) std::fputs("\r\033[K", stderr);
    drawn_ = false;
}

void ProgressBar::say(std::string_view line) {
    clear();
    if (!quiet_) std::fputs(fmt::format("{}\n", model::printable(line)).c_str(), stderr);
}

void ProgressBar::show(bool now) {
    const auto time = Clock::now();
    if (quiet_ || (!now && time - shown_ < (terminal_ ? Clock::duration(kRedraw) : Clock::duration(kPlainPause))))
        return;
    shown_ = time;
    const double done = std::clamp((done_ + share_ * step_) / total_, 0.0, 1.0);
    const double gone = std::chrono::duration<double>(time - started_).count();
    const std::string left = done > kFirstGuess ? ", about " + tool::minutes(gone / done - gone) + " left" : "";
    const auto filled = static_cast<std::size_t>(done * kBarWidth);
    const std::string bar = std::string(filled, '#') + std::string(kBarWidth - filled, '-');
    const std::string line = fmt::format("[{}] {:3.0f} % {}{}  {}", bar, 100 * done, tool::minutes(gone), left, what_);
    std::fputs(terminal_ ? ("\r" + model::printable(line.substr(0, 100)) + "\033[K").c_str()
                         : (model::printable(line) + "\n").c_str(),
               stderr);
    std::fflush(stderr);
    drawn_ = terminal_;
}

}  // namespace dgm::bench
