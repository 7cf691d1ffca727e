// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/dgm_contact_bench.cpp
// A unit sphere of 257 x 257 samples set down on a plane so deep that 5 % of them are beyond it. Counters: share of
// samples in contact, passes of the bulge, volume error of the last contact (or the worst) in units of the removed
// volume.
#include <benchmark/benchmark.h>

#include <dgm/contact.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "dgm_builder.h"

namespace dgm::bench {
namespace {

State sphere(std::uint32_t side, bool plain, bool sewn = true, double radius = 1) {
    const auto point = [side, radius](double i, double j) {
        const double a = 2 * i / (side - 1) - 1, b = 2 * j / (side - 1) - 1, z = 1 - std::fabs(a) - std::fabs(b);
        const double x = z < 0 ? std::copysign(1 - std::fabs(b), a) : a;
        const double y = z < 0 ? std::copysign(1 - std::fabs(a), b) : b;
        const double length = std::sqrt(x * x + y * y + z * z) / radius;
        return test::Point{float(x / length), float(y / length), float(z / length)};
    };
    const test::Image image =
        test::build({test::grid_chart(side, side, point, sewn ? test::octahedral_seams(side) : test::SeamPairs{})});
    StateOptions options;
    options.plain_loops = plain;
    auto asset = Asset::open_memory(image.bytes);
    if (!asset) std::abort();
    auto state = State::create(asset.value().chart(0).value(), options);
    if (!state) std::abort();
    return std::move(state).value();
}

/// The plane that leaves a share of the samples beyond it, pushed in along a fixed tilted direction.
Obstacle plane_for(const State& state, double share) {
    const Vec3 n{-0.3f, 0.5f, -0.8124f};
    double low = 0, high = 1;
    for (int k = 0; k < 40; ++k) {
        const double at = 0.5 * (low + high);
        std::uint32_t beyond = 0;
        for (std::uint32_t s = 0; s < state.sample_count(); ++s) beyond += dot(n, state.positions()[s]) < -at ? 1 : 0;
        (beyond > share * state.sample_count() ? low : high) = at;
    }
    Obstacle plane;
    plane.normal = n;
    plane.point = static_cast<float>(-high / dot(n, n)) * n;
    return plane;
}

void contact(benchmark::State& b, ObstacleKind kind, Bulge bulge, bool plain) {
    State state = sphere(257, plain), other = sphere(65, plain);
    const ContactSolver solver = ContactSolver::create(state).value();
    Obstacle o = plane_for(state, 0.05);
    if (kind != ObstacleKind::Plane) {
        const float length = std::sqrt(dot(o.normal, o.normal));
        o.kind = kind;
        o.point = (1.8f / length) * o.normal;
        o.point = -1.0f * o.point;
        o.radius = 1;
        o.surface = &other;
    }
    ContactOptions options;
    options.bulge = bulge;
    ContactReport r;
    for (auto _ : b) {
        auto done = resolve_contact(state, solver, o, options);
        if (!done) std::abort();
        r = done.value();
        b.PauseTiming();
        state.release();
        state.update_normals();
        b.ResumeTiming();
    }
    b.counters["share"] = static_cast<double>(r.samples) / state.sample_count();
    b.counters["ring"] = static_cast<double>(r.ring) / state.sample_count();
    b.counters["passes"] = r.passes;
    b.counters["volume_error"] = r.volume_error;
}

/// The same with a plane that goes to and fro by a grid step and a half: other samples are beyond it at every call.
/// Each one is made from the shape at rest and has to keep its volume.
void moving_plane(benchmark::State& b, Bulge bulge) {
    State state = sphere(257, false);
    const ContactSolver solver = ContactSolver::create(state).value();
    const Obstacle at = plane_for(state, 0.05);
    const float length = std::sqrt(dot(at.normal, at.normal));
    ContactOptions options;
    options.bulge = bulge;
    double worst = 0, samples = 0, calls = 0;
    for (auto _ : b) {
        Obstacle o = at;
        o.point = o.point + static_cast<float>(1.5 * state.mean_step() * std::sin(calls)) / length * at.normal;
        auto done = resolve_contact(state, solver, o, options);
        if (!done) std::abort();
        worst = std::max(worst, std::fabs(done.value().volume_error));
        samples += done.value().samples;
        ++calls;
        b.PauseTiming();
        state.release();
        state.update_normals();
        b.ResumeTiming();
    }
    b.counters["share"] = samples / calls / state.sample_count();
    b.counters["worst_error"] = worst;
}
BENCHMARK_CAPTURE(moving_plane, exact, Bulge::Exact)->Unit(benchmark::kMicrosecond);

/// A cover of 257 x 257 samples, open, half of it sunk into a cushion as fine: brought out at every turn.
void cover_on_cushion(benchmark::State& b) {
    State cushion = sphere(257, false), cover = sphere(257, false, false, 1.01);
    const ContactSolver solver = ContactSolver::create(cover).value();
    Obstacle o{.kind = ObstacleKind::Surface, .point = {0.01f, -0.004f, 0.012f}, .surface = &cushion};
    ContactReport r;
    for (auto _ : b) {
        auto done = resolve_contact(cover, solver, o);
        if (!done || done.value().status != ContactStatus::Open) std::abort();
        r = done.value();
        b.PauseTiming();
        cover.release();
        b.ResumeTiming();
    }
    b.counters["share"] = static_cast<double>(r.samples) / cover.sample_count();
}
BENCHMARK(cover_on_cushion)->Unit(benchmark::kMicrosecond);

BENCHMARK_CAPTURE(contact, plane_exact, ObstacleKind::Plane, Bulge::Exact, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(contact, plane_exact_plain, ObstacleKind::Plane, Bulge::Exact, true)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(contact, plane_paper, ObstacleKind::Plane, Bulge::Paper, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(contact, plane_none, ObstacleKind::Plane, Bulge::None, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(contact, sphere_exact, ObstacleKind::Sphere, Bulge::Exact, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(contact, surface_exact, ObstacleKind::Surface, Bulge::Exact, false)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace dgm::bench

BENCHMARK_MAIN();
