// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/tool_path.cpp
#include "bench/tool_path.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <locale>
#include <random>
#include <span>
#include <sstream>
#include <string>

#include "bench/recorded_touch.h"
#include "model/codes.h"
#include "model/file_errors.h"
#include "path/tool_path.h"

namespace dgm::bench {
namespace {

constexpr double kStepsPerTick = 0.15, kRoom = 0.42;  ///< of the chart's side, to each side of its middle
constexpr double kTickSeconds = 1e-3;
constexpr double kMeanDepth = 1, kDepthSwing = 1.5;  ///< mean grid steps

/// A point that walks over a chart by its map coordinates; off a free chart it waits where it was.
class Walker {
 public:
    explicit Walker(const State& state) : state_(state) {
        while (sample_ + 1 < state.sample_count() && !state.on_surface(sample_)) ++sample_;
        at_ = state.rest_positions()[sample_];
    }
    /// The surface at row u, column v, and `height` over it along the normal.
    Vec3 over(double u, double v, double height) {
        const std::uint32_t m = state_.rows(), n = state_.cols();
        const auto i = static_cast<std::uint32_t>(std::clamp(u, 0.0, m - 2.0)),
                   j = static_cast<std::uint32_t>(std::clamp(v, 0.0, n - 2.0));
        const auto a = static_cast<float>(u - i), b = static_cast<float>(v - j);
        const std::uint32_t s = i * n + j;
        if (state_.on_surface(s) && state_.on_surface(s + 1) && state_.on_surface(s + n) &&
            state_.on_surface(s + n + 1)) {
            const PointView p = state_.rest_positions();
            at_ = (1 - a) * ((1 - b) * p[s] + b * p[s + 1]) + a * ((1 - b) * p[s + n] + b * p[s + n + 1]);
            sample_ = s;
        }
        return at_ + static_cast<float>(height) * state_.normal(sample_);
    }

 private:
    const State& state_;
    std::uint32_t sample_ = 0;
    Vec3 at_;
};

double diagonal_of(const State& state) {
    Vec3 low{INFINITY, INFINITY, INFINITY}, high = -1.0f * low;
    for (std::uint32_t k = 0; k < state.sample_count(); ++k) {
        if (!state.on_surface(k)) continue;
        const Vec3 p = state.rest_positions()[k];
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    return std::sqrt(static_cast<double>(dot(high - low, high - low)));
}

Vec3 below(const State& state, std::uint32_t sample, double steps) {
    return state.rest_positions()[sample] - static_cast<float>(steps * state.mean_step()) * state.normal(sample);
}

/// True if the first line that is no remark names what the tool does, as paths of pages and samples do.
bool names_kinds(std::ifstream& in) {
    std::string line, word;
    while (std::getline(in, line) && (line.empty() || line.front() == '#')) continue;
    std::istringstream words(line);
    for (int k = 0; k < 5; ++k) words >> word;
    in.clear();
    in.seekg(0);
    word = word.substr(0, word.find(':'));
    return word == "touch" || word == "poke" || word == "grasp" || word == "away";
}

/// A path of pages and samples, `ticks` of it at most.
ToolWay replayed_tools(const formats::ToolPath& path, const double (&offset)[3], std::size_t ticks) {
    const Vec3 origin{static_cast<float>(offset[0]), static_cast<float>(offset[1]), static_cast<float>(offset[2])};
    ToolWay out;
    out.tools = path.tool_count();
    path.replay(
        kTickSeconds,
        [&](std::span<const formats::Knot> knots, float) {
            if (out.ticks() == ticks) return;
            for (const formats::Knot& knot : knots) {
                out.places.push_back(knot.position - origin);
                out.engaged.push_back(knot.engaged ? 1 : 0);
            }
        },
        [](const std::string&) {});
    return out;
}

/// Positions as "x y z" a line.
std::vector<Vec3> bare_positions(std::ifstream& in, const std::filesystem::path& file, const double (&offset)[3]) {
    std::vector<Vec3> out;
    std::string line;
    for (std::size_t number = 1; std::getline(in, line); ++number) {
        if (line.empty() || line.front() == '#') continue;
        std::istringstream words(line);
        words.imbue(std::locale::classic());
        double p[3];
        if (!(words >> p[0] >> p[1] >> p[2]) || !std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
            throw model::Error(model::codes::kReadFailed, "no position \"x y z\"",
                               file.string() + ":" + std::to_string(number));
        out.push_back({static_cast<float>(p[0] - offset[0]), static_cast<float>(p[1] - offset[1]),
                       static_cast<float>(p[2] - offset[2])});
    }
    return out;
}

}  // namespace

std::vector<Vec3> stroke_path(const State& state, std::size_t ticks) {
    const std::uint32_t m = state.rows(), n = state.cols();
    const double rate = kStepsPerTick / (kRoom * (std::max(m, n) - 1));
    std::vector<Vec3> out;
    Walker walker(state);
    for (std::size_t k = 0; k < ticks; ++k) {
        const double t = rate * static_cast<double>(k);
        const double u = (0.5 + kRoom * std::sin(t)) * (m - 1), v = (0.5 + kRoom * std::sin(0.618 * t + 1)) * (n - 1);
        const double depth = kMeanDepth + kDepthSwing * std::sin(static_cast<double>(k) / 50);
        out.push_back(walker.over(u, v, -depth * state.mean_step()));
    }
    return out;
}

std::vector<Vec3> random_path(const State& state, std::size_t ticks) {
    std::mt19937 random(1);  // its numbers are the same everywhere; those of <random>'s distributions are not
    const auto share = [&] { return static_cast<double>(random()) / 4294967296.0; };
    const auto below_count = [&](std::uint32_t count) { return static_cast<std::uint32_t>(share() * count); };
    const std::uint32_t n = state.cols(), grid = state.rows() * n;
    std::vector<Vec3> out;
    std::uint32_t sample = 0;
    for (std::size_t k = 0; k < ticks; ++k) {
        std::uint32_t next = sample;
        if (k == 0 || share() < 0.02) do
                next = below_count(state.sample_count());
            while (!state.on_surface(next));
        else if (const std::uint32_t step = below_count(4); sample < grid) {
            const std::uint32_t i = sample / n, j = sample % n;
            if (step == 0 && i > 0) next = sample - n;
            if (step == 1 && i + 1 < state.rows()) next = sample + n;
            if (step == 2 && j > 0) next = sample - 1;
            if (step == 3 && j + 1 < n) next = sample + 1;
        }
        if (state.on_surface(next)) sample = next;
        out.push_back(below(state, sample, kMeanDepth + kDepthSwing * (2 * share() - 1)));
    }
    return out;
}

std::vector<Vec3> replayed_path(const State& state, std::size_t ticks) {
    struct Line {
        double seconds;
        Vec3 position;
    };
    std::vector<Line> lines;
    Walker walker(state);
    const double diagonal = diagonal_of(state);
    std::istringstream text(kRecordedTouch);
    text.imbue(std::locale::classic());
    for (std::string line; std::getline(text, line);) {
        if (line.empty() || line.front() == '#') continue;
        std::replace(line.begin(), line.end(), ',', ' ');
        std::istringstream words(line);
        words.imbue(std::locale::classic());
        double seconds = 0, u = 0, v = 0, percent = 0;
        if (!(words >> seconds >> u >> v >> percent))
            throw model::Error(model::codes::kInternal, "the program's own recording cannot be read");
        lines.push_back(
            {seconds, walker.over(u * (state.rows() - 1), v * (state.cols() - 1), percent / 100 * diagonal)});
    }
    std::vector<Vec3> out;
    std::size_t next = 1;
    for (double now = lines.front().seconds; out.size() < ticks; now += kTickSeconds) {
        while (next < lines.size() && lines[next].seconds <= now) ++next;
        if (next == lines.size()) {
            next = 1;
            now = lines.front().seconds;
        }
        const Line &a = lines[next - 1], &b = lines[next];
        const auto t = static_cast<float>((now - a.seconds) / (b.seconds - a.seconds));
        out.push_back((1 - t) * a.position + t * b.position);
    }
    return out;
}

ToolWay recorded_path(const std::filesystem::path& file, const double (&offset)[3], std::size_t ticks) {
    std::ifstream in(file);
    if (!in) throw model::unopened_file(file);
    ToolWay way;
    if (names_kinds(in))
        way = replayed_tools(formats::ToolPath(in, file), offset, ticks);
    else
        way.places = bare_positions(in, file, offset);
    if (way.places.empty()) throw model::Error(model::codes::kReadFailed, "it holds no positions", file.string());
    const std::size_t once = way.places.size();
    way.places.resize(ticks * way.tools);
    for (std::size_t k = once; k < way.places.size(); ++k) way.places[k] = way.places[k - once];
    if (way.engaged.empty()) return way;
    way.engaged.resize(way.places.size());
    for (std::size_t k = once; k < way.engaged.size(); ++k) way.engaged[k] = way.engaged[k - once];
    return way;
}

}  // namespace dgm::bench
