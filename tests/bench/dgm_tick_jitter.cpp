// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/dgm_tick_jitter.cpp
// Compute time of whole haptic ticks: median, p99, p99.9 and maximum, beside the peers, in one process.
//
// Ticks in which the thread lost its processor are counted, not timed; what a virtual machine's host steals remains.
//
//   dgm_tick_jitter [TICKS]      default 100000; peers take a tenth of that, at most
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <cstring>

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

/// Of ticks during which the thread kept its processor: what is asked for is time of computing, not of waiting.
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
template <class Turn>
Times measure(const Scene& scene, long ticks, Turn turn) {
    Times t;
    t.us.reserve(static_cast<std::size_t>(ticks));
    for (long k = 0; k < 200; ++k) turn(tool_at(scene, k));
    for (long k = 200; k < 200 + ticks; ++k) {
        const Vec3 tool = tool_at(scene, k);
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
    std::printf("  %-34s median %9.3f  p99 %9.3f  p99.9 %9.3f  max %9.1f us", what, median, t.at(0.99), t.at(0.999),
                t.at(1));
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
    Times t = measure(scene, ticks, [&](Vec3 p) {
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
              measure(scene, few,
                      [&](Vec3 p) {
                          force += brush.tick({p.x, p.y, p.z});
                      }),
              ours);
    }
    std::vector<float> from(3 * points.size() + 64, 1), to(3 * points.size() + 64 + 333);
    float* out = to.data() + 333;  // not the same place in its page as the source
    print("copy of the footprint's positions",
          measure(scene, ticks,
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
}  // namespace
}  // namespace dgm::bench

int main(int argc, char** argv) {
    const long ticks = argc > 1 ? std::atol(argv[1]) : 100000;
    if (ticks < 1000) {
        std::fprintf(stderr, "usage: dgm_tick_jitter [TICKS >= 1000]\n");
        return 1;
    }
    for (const auto& scene : dgm::bench::kScenes) dgm::bench::run(scene, ticks);
    return 0;
}
