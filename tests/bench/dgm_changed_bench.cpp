// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/dgm_changed_bench.cpp
// Cost for a renderer to learn which samples to upload: changed_rows() beside comparing all floats with a copy of its
// own, at rest and while a tool presses and slides, 16 ticks a frame; and how much more than what changed is named.
// Usage: dgm_changed_bench [FRAMES]
#include <dgm/changed.h>
#include <dgm/snapshot.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <span>

#include "scenes.h"

namespace dgm::bench {
namespace {

using Clock = std::chrono::steady_clock;
double micros_since(Clock::time_point start) {
    return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

struct Figures {
    std::vector<double> micros;
    void print(const char* what) {
        std::sort(micros.begin(), micros.end());
        std::printf("  %-34s %8.2f %8.2f %8.2f %8.2f us", what, micros.front(), micros[micros.size() / 2],
                    micros[micros.size() * 99 / 100], micros.back());
    }
};

/// The loop that engines ran before: rows that differ from a copy. @return samples that differ.
std::size_t compare_all(const State& state, std::vector<float>& last) {
    const PointView p = state.positions(), n = state.normals();
    const float* planes[6] = {p.x, p.y, p.z, n.x, n.y, n.z};
    std::size_t changed = 0;
    for (std::size_t k = 0; k < p.count; ++k) {
        int differs = 0;
        for (std::size_t c = 0; c < 6; ++c) {
            differs |= last[6 * k + c] != planes[c][k] ? 1 : 0;
            last[6 * k + c] = planes[c][k];
        }
        changed += static_cast<std::size_t>(differs);
    }
    return changed;
}

void measure(const Scene& scene, float relax_rate, int frames) {
    State state = make_state(scene, Diagonals::Mixed, false);
    const DeformTable table = make_table(scene);
    Snapshots shots = Snapshots::create(state).value();
    std::vector<float> last(6 * std::size_t{state.sample_count()}), held(last.size());
    const std::span<float> positions(held.data(), held.size() / 2),
        normals(positions.data() + positions.size(), positions.size());
    TickOptions options;
    options.d_max = 4;
    options.relax_rate = relax_rate;
    ToolInput in;
    std::uint64_t cursor = 0, frame = 0;
    ChangedRange ranges[64];
    Figures rest, asked, compared, read_changed, read_all;
    double named = 0, changed = 0, worst = 0;
    std::size_t most = 0;
    long at = 0;
    for (int k = -3; k < frames; ++k) {
        for (int turn = 0; turn < 16; ++turn) {
            in.position = tool_at(scene, ++at);
            if (!tick(state, table, options, {&in, 1}, {})) std::abort();
        }
        static_cast<void>(state.positions());  // what fades is brought up to date outside of the clock
        auto start = Clock::now();
        const std::size_t count = changed_rows(state, cursor, std::span(ranges).first(32)).value();
        const double ask = micros_since(start);
        start = Clock::now();
        const std::size_t none = changed_rows(state, cursor, std::span(ranges).subspan(32)).value();
        const double idle = micros_since(start);
        if (none != 0) std::abort();
        start = Clock::now();
        const std::size_t differ = compare_all(state, last);
        const double compare = micros_since(start);
        if (!shots.publish(state)) std::abort();
        start = Clock::now();
        const auto done = shots.read_changed(positions, normals, frame, std::span(ranges).subspan(32));
        const double part = micros_since(start);
        frame = done.value().info.frame;
        start = Clock::now();
        if (!shots.read(positions, normals)) std::abort();
        const double all = micros_since(start);
        if (k < 0) continue;  // the first look is at everything
        double samples = 0;
        for (std::size_t r = 0; r < count; ++r) samples += static_cast<double>(ranges[r].rows) * ranges[r].columns;
        named += samples;
        changed += static_cast<double>(differ);
        worst = std::max(worst, samples / static_cast<double>(std::max<std::size_t>(differ, 1)));
        most = std::max(most, count);
        rest.micros.push_back(idle);
        asked.micros.push_back(ask);
        compared.micros.push_back(compare);
        read_changed.micros.push_back(part);
        read_all.micros.push_back(all);
    }
    std::printf("%s, %s\n", scene.name, relax_rate < 1e6f ? "relaxing" : "springing back at once");
    rest.print("changed_rows at rest");
    std::printf("\n");
    asked.print("changed_rows after 16 ticks");
    std::printf("  %.0f samples named, %.2f x those changed (worst %.2f x), at most %zu ranges\n", named / frames,
                named / changed, worst, most);
    compared.print("comparing all floats");
    std::printf("\n");
    read_changed.print("Snapshots::read_changed");
    std::printf("\n");
    read_all.print("Snapshots::read");
    std::printf("\n");
}
}  // namespace
}  // namespace dgm::bench

int main(int argc, char** argv) {
    const int frames = std::max(20, argc > 1 ? std::atoi(argv[1]) : 500);
    std::printf("%-36s %8s %8s %8s %8s\n", "", "least", "middle", "99 %", "worst");
    for (const dgm::bench::Scene& scene : dgm::bench::kScenes)
        for (const float rate : {std::numeric_limits<float>::infinity(), 20.0f})
            dgm::bench::measure(scene, rate, frames);
    return 0;
}
