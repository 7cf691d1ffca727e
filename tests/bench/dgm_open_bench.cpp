// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/dgm_open_bench.cpp
// Opening, hashing and whole meshes, each with its ratio to copying the same bytes (x_copy). Argument: place in
// kScenes.
#include <benchmark/benchmark.h>

#include <dgm/asset.h>
#include <dgm/reconstruct.h>

#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <string>

#include "scenes.h"

namespace dgm::bench {
namespace {

const Scene& scene_of(const benchmark::State& b) {
    return kScenes[b.range(0)];
}
/// Processor time of this thread: ratios mean something on a busy machine too.
double cpu_seconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

test::Image image_of(const Scene& s) {
    test::ChartSpec chart = test::grid_chart(s.side, s.side, wave);
    chart.add("normal", test::ElementType::kI16, {s.side, s.side, 2},
              std::vector<std::int16_t>(2 * std::size_t{s.side} * s.side, 0));
    return test::build({chart});
}

/// Runs `work` and a copy of `bytes` in turn.
template <class Work>
void beside_copy(benchmark::State& b, std::size_t bytes, Work work) {
    std::vector<char> from(bytes, 1), to(bytes);
    double ours = 0, copies = 0;
    for (auto _ : b) {
        const double start = cpu_seconds();
        work();
        benchmark::ClobberMemory();
        const double middle = cpu_seconds();
        std::memcpy(to.data(), from.data(), bytes);
        benchmark::ClobberMemory();
        const double end = cpu_seconds();
        ours += middle - start;
        copies += end - middle;
        b.SetIterationTime(middle - start);
    }
    b.counters["x_copy"] = ours / copies;
    b.counters["GB/s"] = 1e-9 * static_cast<double>(bytes) * static_cast<double>(b.iterations()) / ours;
}

struct MeshMemory {
    std::vector<float> vertices;
    std::vector<std::uint32_t> indices;
    VertexTarget target;
    explicit MeshMemory(std::uint32_t side)
        : vertices(6 * std::size_t{side} * side, 1), indices(6 * std::size_t{side - 1} * (side - 1), 1) {
        target.memory = std::as_writable_bytes(std::span(vertices));
        target.stride = 6 * sizeof(float);
        target.normal_offset = 3 * sizeof(float);
    }
    [[nodiscard]] std::size_t bytes() const { return 4 * (vertices.size() + indices.size()); }
};

void reconstruct_state(benchmark::State& b, Diagonals diagonals, bool touched) {
    const Scene& s = scene_of(b);
    State state = make_state(s, diagonals, false);
    const DeformTable table = make_table(s);
    Touch touch;
    touch.sample = s.side / 2 * s.side + s.side / 2;
    touch.displacement = {0, 0, 1};
    touch.d_max = 1;
    if (touched && !deform(state, table, touch)) std::abort();
    MeshMemory m(s.side);
    beside_copy(b, m.bytes(), [&] {
        if (!reconstruct(state, m.target, m.indices)) std::abort();
    });
}

void reconstruct_chart(benchmark::State& b) {
    const Scene& s = scene_of(b);
    const test::Image image = image_of(s);
    const Asset asset = std::move(Asset::open_memory(image.bytes)).value();
    const Chart chart = asset.chart(0).value();
    MeshMemory m(s.side);
    beside_copy(b, m.bytes(), [&] {
        if (!reconstruct(chart, m.target, m.indices)) std::abort();
    });
}

void positions_to_buffer(benchmark::State& b) {
    const Scene& s = scene_of(b);
    const test::Image image = image_of(s);
    const Asset asset = std::move(Asset::open_memory(image.bytes)).value();
    const Chart chart = asset.chart(0).value();
    std::vector<float> positions(3 * std::size_t{s.side} * s.side, 1);
    VertexTarget target;
    target.memory = std::as_writable_bytes(std::span(positions));
    beside_copy(b, 4 * positions.size(), [&] {
        if (!reconstruct(chart, target, {})) std::abort();
    });
}

void hash_layers(benchmark::State& b) {
    const test::Image image = image_of(scene_of(b));
    const Asset asset = std::move(Asset::open_memory(image.bytes)).value();
    beside_copy(b, image.bytes.size(), [&] {
        if (!asset.verify()) std::abort();
    });
}

/// From the file's name to the first sample of its surface.
void open_to_first_sample(benchmark::State& b) {
    const test::Image image = image_of(scene_of(b));
    const std::string path = std::string(std::tmpnam(nullptr)) + ".dgm";
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(image.bytes.data()), static_cast<std::streamsize>(image.bytes.size()));
    float sum = 0;
    for (auto _ : b) {
        auto asset = Asset::open(path.c_str());
        if (!asset) std::abort();
        sum += asset.value().chart(0).value().find("geometry").value().as<float>().value()[0];
    }
    benchmark::DoNotOptimize(sum);
    unlink(path.c_str());
}

BENCHMARK_CAPTURE(reconstruct_state, rest, Diagonals::Uniform, false)->DenseRange(0, 2)->UseManualTime();
BENCHMARK_CAPTURE(reconstruct_state, touched, Diagonals::Mixed, true)->DenseRange(0, 2)->UseManualTime();
BENCHMARK(reconstruct_chart)->DenseRange(0, 2)->UseManualTime();
BENCHMARK(positions_to_buffer)->DenseRange(0, 2)->UseManualTime();
BENCHMARK(hash_layers)->DenseRange(0, 2)->UseManualTime();
BENCHMARK(open_to_first_sample)->DenseRange(0, 2);

}  // namespace
}  // namespace dgm::bench

BENCHMARK_MAIN();
