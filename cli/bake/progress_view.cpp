// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bake/progress_view.cpp
#include "bake/progress_view.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>

#include "tool/minutes.h"

namespace dgm::bake {
namespace {

constexpr auto kRedraw = std::chrono::milliseconds(100);
/// Plain lines land in logs: a long stage says so once in a while, a short one not at all.
constexpr auto kPlainPause = std::chrono::seconds(5);
constexpr std::size_t kBarWidth = 20;

std::size_t terminal_columns() {
    winsize size{};
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col >= 40 ? size.ws_col : 80;
}

/// The first `limit` code points of UTF-8 `text`.
std::string shortened(const std::string& text, std::size_t limit) {
    std::size_t points = 0, k = 0;
    for (; k < text.size(); ++k)
        if ((static_cast<unsigned char>(text[k]) & 0xC0U) != 0x80U && points++ == limit) break;
    return text.substr(0, k);
}

/// How much of an asset is done where a stage begins and ends, as measured on organs and garments at 257x257. Only
/// some assets look for a shape first; the others are faster than they promise. The grids of a search repeat these
/// stages under names of their own: they count as the middle.
struct StageSpan {
    std::string_view stage;
    double begin, end;
};
constexpr std::array kStages{StageSpan{"import", 0, 0.01},      StageSpan{"repair", 0.01, 0.02},
                             StageSpan{"textures", 0.02, 0.03}, StageSpan{"shape", 0.03, 0.25},
                             StageSpan{"cut", 0.03, 0.2},       StageSpan{"map", 0.03, 0.42},
                             StageSpan{"fit", 0.42, 0.81},      StageSpan{"layers", 0.81, 0.87},
                             StageSpan{"measure", 0.87, 0.99},  StageSpan{"write", 0.99, 1}};

double share_of_asset(std::string_view stage, double share) {
    for (const StageSpan& span : kStages)
        if (span.stage == stage) return span.begin + share * (span.end - span.begin);
    return 0.08;
}

}  // namespace

ProgressView::ProgressView(ProgressStyle style, std::vector<std::string> names, std::vector<double> weights)
    : style_(style != ProgressStyle::kAuto ? style
             : isatty(STDERR_FILENO) != 0  ? ProgressStyle::kBar
                                           : ProgressStyle::kPlain),
      names_(std::move(names)),
      weights_(std::move(weights)) {
    weights_.resize(names_.size(), 1);
    for (const double weight : weights_) total_ += weight;
}

void ProgressView::start(std::size_t asset) {
    active_[asset] = {"start", 0, 0, Clock::now()};
    if (style_ == ProgressStyle::kPlain)
        std::fputs(fmt::format("[{}/{}] {}\n", asset + 1, names_.size(), names_[asset]).c_str(), stderr);
}

void ProgressView::update(std::size_t asset, std::string_view stage, double share) {
    Active& active = active_[asset];
    active.stage = stage;
    active.share = share;
    active.done = std::max(active.done, share_of_asset(stage, share));
    const auto now = Clock::now();
    if (style_ != ProgressStyle::kPlain || now - active.said < kPlainPause) return;
    active.said = now;
    std::fputs(
        fmt::format("[{}/{}] {}: {} {:.0f} %{}\n", asset + 1, names_.size(), names_[asset], stage, 100 * share, to_go())
            .c_str(),
        stderr);
}

void ProgressView::end(std::size_t asset) {
    if (active_.erase(asset) > 0)
        done_ += weights_[asset];
    else
        total_ -= weights_[asset];
    ++ended_;
}

std::string ProgressView::to_go() const {
    double done = done_;
    for (const auto& [asset, active] : active_) done += active.done * weights_[asset];
    const double share = total_ > 0 ? done / total_ : 0;
    // The first seconds promise anything.
    constexpr double kLeast = 0.02;
    const double elapsed = std::chrono::duration<double>(Clock::now() - begun_).count();
    return share < kLeast ? std::string() : fmt::format(", {} to go", tool::minutes(elapsed * (1 - share) / share));
}

std::string ProgressView::bar_line(std::size_t columns) const {
    const double done = static_cast<double>(ended_) / static_cast<double>(std::max<std::size_t>(1, names_.size()));
    const auto filled = static_cast<std::size_t>(done * static_cast<double>(kBarWidth));
    std::string head = fmt::format("[{:#>{}}{:.>{}}] {}/{}", "", filled, "", kBarWidth - filled, ended_, names_.size());
    const double elapsed = std::chrono::duration<double>(Clock::now() - begun_).count();
    head += fmt::format("  {}", tool::minutes(elapsed));
    head += to_go();
    for (const auto& [asset, active] : active_)
        head += fmt::format("  {}: {} {:.0f} %", names_[asset], active.stage, 100 * active.share);
    return shortened(head, columns - 1);
}

void ProgressView::tick() {
    if (style_ != ProgressStyle::kBar || Clock::now() - drawn_ < kRedraw) return;
    drawn_ = Clock::now();
    on_screen_ = true;
    std::fputs(fmt::format("\r{}\x1b[K", bar_line(terminal_columns())).c_str(), stderr);
    std::fflush(stderr);
}

void ProgressView::clear() {
    if (!on_screen_) return;
    on_screen_ = false;
    drawn_ = {};
    std::fputs("\r\x1b[K", stderr);
    std::fflush(stderr);
}

}  // namespace dgm::bake
