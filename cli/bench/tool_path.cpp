// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/tool_path.cpp
#include "bench/tool_path.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <locale>
#include <random>
#include <sstream>
#include <string>

#include "model/codes.h"

namespace dgm::bench {
namespace {

constexpr double kStepsPerTick = 0.15, kRoom = 0.42;  ///< of the chart's side, to each side of its middle
constexpr double kMeanDepth = 1, kDepthSwing = 1.5;   ///< mean grid steps

Vec3 below(const State& state, std::uint32_t sample, double steps) {
    return state.rest_positions()[sample] - static_cast<float>(steps * state.mean_step()) * state.normal(sample);
}

}  // namespace

std::vector<Vec3> stroke_path(const State& state, std::size_t ticks) {
    const std::uint32_t m = state.rows(), n = state.cols();
    const double rate = kStepsPerTick / (kRoom * (std::max(m, n) - 1));
    std::vector<Vec3> out;
    std::uint32_t corner = 0;
    while (corner + 1 < state.sample_count() && !state.on_surface(corner)) ++corner;
    Vec3 at = state.rest_positions()[corner];
    for (std::size_t k = 0; k < ticks; ++k) {
        const double t = rate * static_cast<double>(k);
        const double u = (0.5 + kRoom * std::sin(t)) * (m - 1), v = (0.5 + kRoom * std::sin(0.618 * t + 1)) * (n - 1);
        const auto i = static_cast<std::uint32_t>(std::min(u, m - 2.0)),
                   j = static_cast<std::uint32_t>(std::min(v, n - 2.0));
        const auto a = static_cast<float>(u - i), b = static_cast<float>(v - j);
        const std::uint32_t s = i * n + j;
        // Off a free chart the tool waits where it was.
        if (state.on_surface(s) && state.on_surface(s + 1) && state.on_surface(s + n) && state.on_surface(s + n + 1)) {
            const PointView p = state.rest_positions();
            at = (1 - a) * ((1 - b) * p[s] + b * p[s + 1]) + a * ((1 - b) * p[s + n] + b * p[s + n + 1]);
            corner = s;
        }
        const double depth = kMeanDepth + kDepthSwing * std::sin(static_cast<double>(k) / 50);
        out.push_back(at - static_cast<float>(depth * state.mean_step()) * state.normal(corner));
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

std::vector<Vec3> recorded_path(const std::filesystem::path& file, const double (&offset)[3], std::size_t ticks) {
    std::ifstream in(file);
    if (!in) throw model::Error(model::codes::kFileMissing, "it cannot be read", file.string());
    std::vector<Vec3> recorded;
    std::string line;
    for (std::size_t number = 1; std::getline(in, line); ++number) {
        if (line.empty() || line.front() == '#') continue;
        std::istringstream words(line);
        words.imbue(std::locale::classic());
        double p[3];
        if (!(words >> p[0] >> p[1] >> p[2]) || !std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
            throw model::Error(model::codes::kReadFailed, "no position \"x y z\"",
                               file.string() + ":" + std::to_string(number));
        recorded.push_back({static_cast<float>(p[0] - offset[0]), static_cast<float>(p[1] - offset[1]),
                            static_cast<float>(p[2] - offset[2])});
    }
    if (recorded.empty()) throw model::Error(model::codes::kReadFailed, "it holds no positions", file.string());
    std::vector<Vec3> out;
    for (std::size_t k = 0; k < ticks; ++k) out.push_back(recorded[k % recorded.size()]);
    return out;
}

}  // namespace dgm::bench
