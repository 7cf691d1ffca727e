// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/dgm_tick_jitter.cpp
// Compute time of whole haptic ticks: median, p99, p99.9 and maximum, beside the peers, in one process.
//
// Ticks in which the thread lost its processor are counted, not timed; what a virtual machine's host steals remains.
//
//   dgm_tick_jitter [TICKS] [MAP.dgm...]      default 100000; peers take a tenth of that, at most
//
// Without maps: a wavy sheet at three sizes, all diagonals 0 and mixed. With maps: their largest chart, with the
// diagonals its bake chose, by a tool that slides 0.15 grid steps a tick, away from the border of the grid (where seams
// are) and along it; the reach is 11, 33 or 65 mean steps by the size of the grid. scripts/tick-figures bakes some.
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <numeric>

#include "map_scene.h"
#include "peers.h"
#include "scenes.h"

namespace dgm::bench {
namespace {

double now_us() {
    return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Times the thread was taken off the processor.
long preemptions() {
    rusage u{};
    getrusage(RUSAGE_THREAD, &u);
    return u.ru_nivcsw;
}

/// Times of the ticks during which the thread kept its processor: time of computing, not of waiting.
struct Times {
    std::vector<double> us;
    long preempted = 0;
    double at(double share) {
        if (us.empty()) return std::nan("");  // the machine was too busy
        const auto k = static_cast<std::size_t>(share * static_cast<double>(us.size() - 1));
        std::nth_element(us.begin(), us.begin() + static_cast<std::ptrdiff_t>(k), us.end());
        return us[k];
    }
};

/// The tool's place is worked out before the clock starts.
template <class Where, class Turn>
Times measure(Where tool_at, long ticks, Turn turn) {
    Times t;
    t.us.reserve(static_cast<std::size_t>(ticks));
    for (long k = 0; k < 200; ++k) turn(tool_at(k));
    for (long k = 200; k < 200 + ticks; ++k) {
        const Vec3 tool = tool_at(k);
        const long switches = preemptions();
        const double before = now_us();
        turn(tool);
        const double took = now_us() - before;
        if (preemptions() == switches)
            t.us.push_back(took);
        else
            ++t.preempted;
    }
    return t;
}

double print(const char* what, Times t, double ours = 0) {
    const double median = t.at(0.5);
    const double mean = std::accumulate(t.us.begin(), t.us.end(), 0.0) / static_cast<double>(t.us.size());
    std::printf("  %-34s median %9.3f  mean %9.3f  p99 %9.3f  p99.9 %9.3f  max %9.1f us", what, median, mean,
                t.at(0.99), t.at(0.999), t.at(1));
    if (ours > 0) std::printf("  = %.2f x the tick", median / ours);
    if (t.preempted > 0) std::printf("  (%ld preempted)", t.preempted);
    std::printf("\n");
    return median;
}

Times run_tick(const Scene& scene, long ticks, Diagonals diagonals, bool plain, float rate, long* lost) {
    State state = make_state(scene, diagonals, plain);
    const DeformTable table = make_table(scene);
    TickOptions options;
    options.d_max = 4;
    options.relax_rate = rate;
    ToolInput in;
    ToolOutput out;
    long searched = 0;
    Times t = measure([&](long k) { return tool_at(scene, k); }, ticks,
                      [&](Vec3 p) {
                          in.position = p;
                          if (!tick(state, table, options, {&in, 1}, {&out, 1}) || !out.hit) std::abort();
                          searched += out.lost;
                      });
    if (lost != nullptr) *lost = searched;
    return t;
}

void run(const Scene& scene, long ticks) {
    std::printf("%s\n", scene.name);
    const float at_once = std::numeric_limits<float>::infinity();
    long lost = 0;
    const double ours = print("tick", run_tick(scene, ticks, Diagonals::Uniform, false, at_once, &lost));
    std::printf("  %-34s %.2f %% of ticks searched the pyramid\n", "",
                100.0 * static_cast<double>(lost) / (200.0 + static_cast<double>(ticks)));
    print("tick, mixed diagonals", run_tick(scene, ticks, Diagonals::Mixed, false, at_once, nullptr), ours);
    print("tick, plain loops", run_tick(scene, ticks / 4, Diagonals::Uniform, true, at_once, nullptr), ours);
    print("tick, relaxing at 20 / s", run_tick(scene, ticks / 4, Diagonals::Uniform, false, 20, nullptr), ours);

    std::vector<Vec> points;
    for (std::uint32_t i = 0; i < scene.side; ++i)
        for (std::uint32_t j = 0; j < scene.side; ++j) points.push_back(wave(i, j));
    const long few = std::max(ticks / (scene.side > 1000 ? 200 : 10), 20L);
    Mesh mesh(scene.side, points);
    float force = 0;
    for (const bool tree : {true, false}) {
        Brush brush(mesh, tree, scene.sigma(), static_cast<float>(scene.reach()));
        print(tree ? "kd-tree brush (nanoflann)" : "scan of all vertices",
              measure([&](long k) { return tool_at(scene, k); }, few,
                      [&](Vec3 p) {
                          force += brush.tick({p.x, p.y, p.z});
                      }),
              ours);
    }
    std::vector<float> from(3 * points.size() + 64, 1), to(3 * points.size() + 64 + 333);
    float* out = to.data() + 333;  // not the same place in its page as the source
    print("copy of the footprint's positions",
          measure([&](long k) { return tool_at(scene, k); }, ticks,
                  [&](Vec3 p) {
                      const std::uint32_t first = (scene.side - scene.window) / 2;
                      for (std::size_t axis = 0; axis < 3; ++axis)
                          for (std::uint32_t i = first; i < first + scene.window; ++i) {
                              const std::size_t at = axis * points.size() + std::size_t{i} * scene.side + first;
                              std::memcpy(out + at, from.data() + at, scene.window * sizeof(float));
                          }
                      from[0] = out[static_cast<std::size_t>(p.x)];
                  }),
          ours);
    if (force == 12345) std::printf("%f", static_cast<double>(from[0]));
}

Times run_map(const MapScene& scene, long ticks, Footprint footprint, bool at_seam, bool plain) {
    State state = scene.state(plain);
    const DeformTable table = scene.table();
    TickOptions options;
    options.d_max = 4 * state.mean_step();
    options.footprint = footprint;
    ToolInput in;
    ToolOutput out;
    return measure([&](long k) { return scene.tool_at(state, k, at_seam); }, ticks,
                   [&](Vec3 p) {
                       in.position = p;
                       if (!tick(state, table, options, {&in, 1}, {&out, 1})) std::abort();
                   });
}

void run(const MapScene& scene, long ticks) {
    std::printf("%s, reach %u\n", scene.name(), scene.reach());
    const double ours = print("tick", run_map(scene, ticks, Footprint::Surface, false, false));
    print("tick at the border", run_map(scene, ticks, Footprint::Surface, true, false), ours);
    print("tick, plain loops", run_map(scene, ticks / 4, Footprint::Surface, false, true), ours);
    print("tick, geodesic", run_map(scene, ticks / 4, Footprint::Geodesic, false, false), ours);
    print("tick, eq. 7 as printed", run_map(scene, ticks / 4, Footprint::Grid, false, false), ours);
    print("the same at the border", run_map(scene, ticks / 4, Footprint::Grid, true, false), ours);
    State state = scene.state(false);
    const float step = state.mean_step();
    Mesh mesh = scene.mesh(state);
    Brush brush(mesh, true, scene.sigma() * step * step, static_cast<float>(scene.reach()) * step);
    const long few = std::max(ticks / 100, 20L);
    float force = 0;
    print("kd-tree brush (nanoflann)",
          measure([&](long k) { return scene.tool_at(state, k, false); }, few,
                  [&](Vec3 p) {
                      force += brush.tick({p.x, p.y, p.z});
                  }),
          ours);
    std::printf("  %-34s pressed in %ld of %ld ticks%s\n", "", brush.pressed(), few + 200, force == 12345 ? "!" : "");
}
}  // namespace
}  // namespace dgm::bench

int main(int argc, char** argv) {
    const long ticks = argc > 1 ? std::atol(argv[1]) : 100000;
    if (ticks < 1000) {
        std::fprintf(stderr, "usage: dgm_tick_jitter [TICKS >= 1000] [MAP.dgm...]\n");
        return 1;
    }
    for (int k = 2; k < argc; ++k) dgm::bench::run(dgm::bench::MapScene(argv[k]), ticks);
    if (argc > 2) return 0;
    for (const auto& scene : dgm::bench::kScenes) dgm::bench::run(scene, ticks);
    return 0;
}
