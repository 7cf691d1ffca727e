// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/dgm_pick_bench.cpp
// Times of pick_ray(): least, middle, 99th percentile and worst of many single calls, and the hit of the worst ray.
// Usage: dgm_pick_bench [RAYS]
#include <dgm/pick.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <random>

#include "scenes.h"

namespace dgm::bench {
namespace {

using Clock = std::chrono::steady_clock;

/// A closed body with three bulges: the octahedral unfolding, all four sides seams.
State make_body(const Scene& scene) {
    const std::uint32_t n = scene.side;
    const auto body = [n](double i, double j) {
        const double a = 2 * i / (n - 1) - 1, b = 2 * j / (n - 1) - 1, z = 1 - std::fabs(a) - std::fabs(b);
        const double x = z < 0 ? std::copysign(1 - std::fabs(b), a) : a,
                     y = z < 0 ? std::copysign(1 - std::fabs(a), b) : b;
        const double r = (1 + 0.4 * std::sin(5 * x) * std::cos(4 * z)) * n / 6 / std::sqrt(x * x + y * y + z * z);
        return test::Point{static_cast<float>(r * x), static_cast<float>(r * y), static_cast<float>(r * z)};
    };
    const test::Image image = test::build({test::grid_chart(n, n, body, test::octahedral_seams(n))});
    auto asset = Asset::open_memory(image.bytes);
    auto state = asset ? State::create(asset.value().chart(0).value()) : Result<State>(asset.error());
    if (!state) std::abort();
    return std::move(state).value();
}

struct Ray {
    Vec3 origin, direction;
};
using Source = std::function<Ray(std::mt19937&)>;

Vec3 anywhere(std::mt19937& random, float size) {
    std::normal_distribution<float> normal(0, size);
    const float x = normal(random), y = normal(random), z = normal(random);
    return {x, y, z};
}

void measure(const char* surface, const char* rays, State& state, const Source& source, std::size_t count) {
    std::mt19937 random(7);
    std::vector<Ray> all(count);
    for (Ray& r : all) r = source(random);
    std::vector<double> micros(count, 1e9);
    std::size_t hits = 0;
    for (int round = 0; round < 3; ++round) {  // the least of three calls is the ray's own, without interruptions
        hits = 0;
        for (std::size_t k = 0; k < count; ++k) {
            const auto start = Clock::now();
            const bool hit = pick_ray(state, all[k].origin, all[k].direction).ok();
            micros[k] = std::min(micros[k], std::chrono::duration<double, std::micro>(Clock::now() - start).count());
            hits += hit ? 1 : 0;
        }
    }
    const std::size_t worst = static_cast<std::size_t>(std::max_element(micros.begin(), micros.end()) - micros.begin());
    std::vector<double> sorted = micros;
    std::sort(sorted.begin(), sorted.end());
    const Ray& r = all[worst];
    const auto met = pick_ray(state, r.origin, r.direction);
    char place[64] = "nothing";
    if (met) std::snprintf(place, sizeof place, "quad (%u, %u)", met.value().row, met.value().column);
    std::printf("%-14s %-10s %6.2f %7.2f %6.2f %7.2f us  %3.0f %% hit; the worst met %s\n", surface, rays, sorted[0],
                sorted[count / 2], sorted[count * 99 / 100], micros[worst],
                100 * static_cast<double>(hits) / static_cast<double>(count), place);
}

void measure_scene(const Scene& scene, std::size_t count) {
    const float size = static_cast<float>(scene.side);
    const auto aimed = [size](Vec3 middle, float spread) {
        return [=](std::mt19937& random) {
            const Vec3 from = middle + anywhere(random, 2 * size), to = middle + anywhere(random, spread);
            return Ray{from, to - from};
        };
    };
    const Vec3 middle{size / 2, size / 2, 0};
    State sheet = make_state(scene, Diagonals::Mixed, false);
    const DeformTable table = make_table(scene);
    TickOptions options;
    options.d_max = 4;
    options.relax_rate = 20;
    ToolInput in;
    for (long k = 0; k < 200; ++k) {
        in.position = tool_at(scene, k);
        if (!tick(sheet, table, options, {&in, 1}, {})) std::abort();
    }
    std::printf("%s\n", scene.name);
    measure("pressed sheet", "aimed", sheet, aimed(middle, size / 5), count);
    measure(
        "pressed sheet", "grazing", sheet,
        [&](std::mt19937& random) {
            const float at = std::uniform_real_distribution<float>(0, size)(random);
            return Ray{{-size, at, 3.5f},
                       {2 * size, size / 2 - at, -7 * std::uniform_real_distribution<float>()(random)}};
        },
        count);
    State body = make_body(scene);
    measure("closed body", "aimed", body, aimed({}, size / 12), count);
    measure("closed body", "silhouette", body, aimed({}, size / 4), count);
    measure(
        "closed body", "inside", body,
        [&](std::mt19937& random) {
            return Ray{anywhere(random, size / 40), anywhere(random, 1)};
        },
        count);
}
}  // namespace
}  // namespace dgm::bench

int main(int argc, char** argv) {
    const long wish = argc > 1 ? std::atol(argv[1]) : 20000;
    std::printf("%-14s %-10s %6s %7s %6s %7s\n", "surface", "rays", "least", "middle", "99 %", "worst");
    for (const dgm::bench::Scene& scene : dgm::bench::kScenes)
        dgm::bench::measure_scene(scene, static_cast<std::size_t>(std::max(100l, wish)));
    return 0;
}
