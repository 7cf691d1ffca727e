// SPDX-License-Identifier: GPL-3.0-or-later
// tests/e2e/touch_reference.cpp
// What a page must find, natively, with plain loops.
//
//   dgm_touch_reference MAP.dgm picks            rays "OX OY OZ DX DY DZ" from stdin; a line each: corners and weights
//   dgm_touch_reference MAP.dgm replay PATH OUT  runs a path as samples/press_and_pull does; writes x, y, z of all
//                                                samples to OUT, prints the forces' sum
//   dgm_touch_reference MAP.dgm ticks PATH       "KIND X Y Z" of each tool of each tick of a replay, in the path's
//                                                frame
//   dgm_touch_reference MAP.dgm time PATH        microseconds a tick of a replay, the best of five
#include <dgm/asset.h>
#include <dgm/deform.h>
#include <dgm/pick.h>
#include <dgm/state.h>
#include <dgm/tick.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <span>
#include <string>
#include <utility>

#include "path/tool_path.h"

namespace {
constexpr std::uint32_t kSteps = 45;  // of the kernel

template <class T>
T take(dgm::Result<T> result) {
    if (result) return std::move(result).value();
    std::fprintf(stderr, "%s\n", result.error().message);
    std::exit(1);
}

void picks(dgm::State& state) {
    dgm::Vec3 o, d;
    while (std::scanf("%f %f %f %f %f %f", &o.x, &o.y, &o.z, &d.x, &d.y, &d.z) == 6) {
        const auto hit = dgm::pick_ray(state, o, d);
        if (!hit) {
            std::printf("none\n");
            continue;
        }
        const dgm::RayHit& h = hit.value();
        std::printf("%u %u %u %.9g %.9g %.9g %.9g\n", h.corners[0], h.corners[1], h.corners[2],
                    double{h.barycentric[0]}, double{h.barycentric[1]}, double{h.barycentric[2]}, double{h.distance});
    }
}

void ticks(const char* path) {
    constexpr const char* kNames[] = {"touch", "poke", "grasp"};
    dgm::formats::ToolPath(path).replay(
        1e-3,
        [&](std::span<const dgm::formats::Knot> knots, float) {
            for (const dgm::formats::Knot& knot : knots)
                std::printf("%s %.9g %.9g %.9g%s", knot.engaged ? kNames[static_cast<int>(knot.kind)] : "away",
                            double{knot.position.x}, double{knot.position.y}, double{knot.position.z},
                            knot.tool + 1 < knots.size() ? " " : "\n");
        },
        [](const std::string&) {});
}

struct Replayed {
    double forces = 0;  ///< their sum
    std::uint32_t ticks = 0;
};

Replayed run_path(dgm::State& state, const dgm::Chart& chart, const dgm::formats::ToolPath& path) {
    const auto size = path.touch_size().value_or(dgm::formats::TouchSize{4.5, 5, false});
    const auto table = take(
        dgm::DeformTable::create({.end = dgm::KernelEnd::Compact, .sigma = kSteps * kSteps / 5.0F, .reach = kSteps}));
    const dgm::TickOptions options{.d_max = static_cast<float>(size.d_max),
                                   .grasp_distance = path.touch_size() ? static_cast<float>(size.size) : 0,
                                   .footprint = dgm::Footprint::Geodesic,
                                   .mode = size.stays ? dgm::DeformMode::Plastic : dgm::DeformMode::Elastic,
                                   .step = static_cast<float>(size.size / kSteps)};
    const auto offset = chart.offset();
    const dgm::Vec3 origin{static_cast<float>(offset[0]), static_cast<float>(offset[1]), static_cast<float>(offset[2])};
    Replayed out;
    path.replay(
        1e-3,
        [&](std::span<const dgm::formats::Knot> knots, float) {
            dgm::ToolInput inputs[dgm::formats::kMostTools];
            dgm::ToolOutput felt[dgm::formats::kMostTools];
            for (const dgm::formats::Knot& k : knots)
                inputs[k.tool] = {
                    .tool = k.tool, .kind = k.kind, .position = k.position - origin, .engaged = k.engaged};
            static_cast<void>(take(dgm::tick(state, table, options, {inputs, knots.size()}, felt)));
            for (const dgm::ToolOutput& f : std::span(felt, knots.size()))
                out.forces += double{f.force.x} + double{f.force.y} + double{f.force.z};
            ++out.ticks;
        },
        [](const std::string&) {});
    return out;
}

void time_path(dgm::State& state, const dgm::Chart& chart, const char* file) {
    const dgm::formats::ToolPath path(file);
    double best = 1e300;
    for (int k = 0; k < 5; ++k) {
        state.reset();
        const auto began = std::chrono::steady_clock::now();
        const Replayed done = run_path(state, chart, path);
        const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - began;
        best = std::min(best, spent.count() / done.ticks);
    }
    std::printf("%.3f\n", best);
}

void replay(dgm::State& state, const dgm::Chart& chart, const char* file, const char* out) {
    const double sum = run_path(state, chart, dgm::formats::ToolPath(file)).forces;
    std::ofstream shape(out, std::ios::binary);
    const auto positions = state.positions();
    for (const float* axis : {positions.x, positions.y, positions.z})
        shape.write(reinterpret_cast<const char*>(axis), static_cast<std::streamsize>(positions.count * sizeof(float)));
    std::printf("%.17g\n", sum);
}
}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) return 1;
    const dgm::Asset asset = take(dgm::Asset::open(argv[1]));
    const dgm::Chart chart = take(asset.chart(0));
    dgm::State state = take(dgm::State::create(chart, {.plain_loops = true}));
    if (std::string(argv[2]) == "picks")
        picks(state);
    else if (argc == 4 && std::string(argv[2]) == "ticks")
        ticks(argv[3]);
    else if (argc == 4 && std::string(argv[2]) == "time")
        time_path(state, chart, argv[3]);
    else if (argc == 5)
        replay(state, chart, argv[3], argv[4]);
}
