// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/dgm_runtime_bench.cpp
// The parts of a tick one by one, and a copy of the same bytes beside them. Argument: place in kScenes.
#include <benchmark/benchmark.h>

#include <dgm/collide.h>

#include <cstring>
#include <limits>

#include "scenes.h"

namespace dgm::bench {
namespace {

const Scene& scene_of(const benchmark::State& b) {
    return kScenes[b.range(0)];
}
std::uint32_t middle(const Scene& s) {
    return s.side / 2 * s.side + s.side / 2;
}

void copy_footprint(benchmark::State& b) {
    const Scene& s = scene_of(b);
    const std::size_t plane = std::size_t{s.side} * s.side;
    std::vector<float> from(3 * plane, 1), to(3 * plane + 333);
    const std::uint32_t first = (s.side - s.window) / 2;
    for (auto _ : b) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (std::uint32_t i = first; i < first + s.window; ++i) {
                const std::size_t at = axis * plane + std::size_t{i} * s.side + first;
                std::memcpy(to.data() + 333 + at, from.data() + at, s.window * sizeof(float));
            }
        benchmark::ClobberMemory();
    }
}

void deform_part(benchmark::State& b, Footprint footprint, bool seam, KernelEnd end) {
    const Scene& s = scene_of(b);
    State state = make_state(s, Diagonals::Mixed, false, seam);
    const DeformTable table = make_table(s, end);
    Touch touch;
    touch.sample = seam ? s.side / 2 * s.side + 3 : middle(s);
    touch.displacement = {0, 0, 1e-6f};
    touch.d_max = 1;
    touch.footprint = footprint;
    touch.step = 1;
    std::uint32_t samples = 0;
    for (auto _ : b) samples = deform(state, table, touch).value().samples;
    b.counters["samples"] = samples;
}

void normals_part(benchmark::State& b, Diagonals diagonals, bool plain) {
    const Scene& s = scene_of(b);
    State state = make_state(s, diagonals, plain);
    const DeformTable table = make_table(s);
    Touch touch;
    touch.sample = middle(s);
    touch.displacement = {0, 0, 1e-6f};
    touch.d_max = 1;
    for (auto _ : b) {
        if (!deform(state, table, touch)) std::abort();
        state.update_normals();
    }
}

void nearest_part(benchmark::State& b) {
    const Scene& s = scene_of(b);
    State state = make_state(s, Diagonals::Uniform, false);
    long k = 0;
    for (auto _ : b) benchmark::DoNotOptimize(nearest_sample(state, tool_at(s, ++k)).value().sample);
}

/// `read_every`: ticks from one look at all positions and normals to the next; 0: never.
void whole_tick(benchmark::State& b, float relax_rate, std::size_t read_every) {
    const Scene& s = scene_of(b);
    State state = make_state(s, Diagonals::Uniform, false);
    const DeformTable table = make_table(s);
    TickOptions options;
    options.d_max = 4;
    options.relax_rate = relax_rate;
    std::vector<Vec3> path;
    for (long k = 0; k < 4096; ++k) path.push_back(tool_at(s, k));
    ToolInput in;
    ToolOutput out;
    std::size_t k = 0;
    for (auto _ : b) {
        in.position = path[++k % path.size()];
        if (!tick(state, table, options, {&in, 1}, {&out, 1})) std::abort();
        if (read_every != 0 && k % read_every == 0) benchmark::DoNotOptimize(state.normals().x);
    }
}

void geodesic_961(benchmark::State& b) {
    Scene s = kScenes[1];
    s.window = 31;
    State state = make_state(s, Diagonals::Mixed, false);
    KernelOptions kernel;
    kernel.reach = 17;  // pi 17.5^2 = 962
    kernel.sigma = 72;
    const DeformTable table = DeformTable::create(kernel).value();
    Touch touch;
    touch.sample = middle(s);
    touch.displacement = {0, 0, 1e-6f};
    touch.d_max = 1;
    touch.footprint = Footprint::Geodesic;
    touch.step = 1.06f;
    std::uint32_t samples = 0;
    for (auto _ : b) samples = deform(state, table, touch).value().samples;
    b.counters["samples"] = samples;
}

BENCHMARK(copy_footprint)->DenseRange(0, 2);
BENCHMARK_CAPTURE(deform_part, grid, Footprint::Grid, false, KernelEnd::Printed)->DenseRange(0, 2);
BENCHMARK_CAPTURE(deform_part, grid_at_seam, Footprint::Grid, true, KernelEnd::Printed)->DenseRange(0, 2);
BENCHMARK_CAPTURE(deform_part, geodesic, Footprint::Geodesic, false, KernelEnd::Compact)->DenseRange(0, 1);
BENCHMARK_CAPTURE(normals_part, uniform, Diagonals::Uniform, false)->DenseRange(0, 2);
BENCHMARK_CAPTURE(normals_part, mixed, Diagonals::Mixed, false)->DenseRange(0, 2);
BENCHMARK_CAPTURE(normals_part, plain, Diagonals::Mixed, true)->DenseRange(0, 2);
constexpr float kAtOnce = std::numeric_limits<float>::infinity();
BENCHMARK_CAPTURE(whole_tick, at_once, kAtOnce, 0)->DenseRange(0, 2);
BENCHMARK_CAPTURE(whole_tick, relaxing, 20.0f, 0)->DenseRange(0, 2);
BENCHMARK_CAPTURE(whole_tick, relaxing_read_every_16th, 20.0f, 16)->DenseRange(0, 2);
BENCHMARK_CAPTURE(whole_tick, relaxing_read_each, 20.0f, 1)->DenseRange(0, 2);
BENCHMARK(nearest_part)->DenseRange(0, 2);
BENCHMARK(geodesic_961);

}  // namespace
}  // namespace dgm::bench

BENCHMARK_MAIN();
