// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/scenes.h
// The three sizes of the targets, as a wavy sheet with grid step 1 and a tool that presses and slides.
#pragma once
#include <dgm/deform.h>
#include <dgm/state.h>
#include <dgm/tick.h>

#include <cmath>
#include <cstdlib>
#include <optional>
#include <vector>

#include "dgm_builder.h"

namespace dgm::bench {

struct Scene {
    const char* name;
    std::uint32_t side, window;  ///< samples a side of the grid and of the footprint
    [[nodiscard]] std::uint32_t reach() const { return window / 2 + 1; }
    [[nodiscard]] float sigma() const { return static_cast<float>(reach()) * static_cast<float>(reach()) / 4; }
};
inline constexpr Scene kScenes[] = {
    {"81x81, 21x21", 81, 21}, {"257x257, 65x65", 257, 65}, {"1025x1025, 129x129", 1025, 129}};

inline test::Point wave(double i, double j) {
    return {static_cast<float>(i), static_cast<float>(j),
            static_cast<float>(3 * std::sin(i / 13) * std::cos(j / 17) + 0.02 * std::sin(1.3 * i + 0.7 * j))};
}

enum class Diagonals { Uniform, Mixed };

inline State make_state(const Scene& scene, Diagonals diagonals, bool plain, bool seams = false) {
    const std::uint32_t n = scene.side;
    test::ChartSpec chart = test::grid_chart(n, n, wave, seams ? test::tube_seams(n, n) : test::SeamPairs{});
    if (diagonals == Diagonals::Mixed) {
        std::vector<std::uint8_t> bits((n - 1) * (n - 1));
        std::uint32_t random = 12345;
        for (std::uint8_t& bit : bits) {
            random = random * 1664525 + 1013904223;
            bit = static_cast<std::uint8_t>(random >> 31);
        }
        chart.add("diagonals", test::ElementType::kU8, {n - 1, n - 1}, bits);
    }
    const test::Image image = test::build({chart});
    StateOptions options;
    options.plain_loops = plain;
    auto asset = Asset::open_memory(image.bytes);
    if (!asset) std::abort();
    auto state = State::create(asset.value().chart(0).value(), options);
    if (!state) std::abort();
    return std::move(state).value();
}

inline DeformTable make_table(const Scene& scene, KernelEnd end = KernelEnd::Printed) {
    KernelOptions kernel;
    kernel.sigma = scene.sigma();
    kernel.reach = scene.reach();
    kernel.end = end;
    return DeformTable::create(kernel).value();
}

/// A closed walk over the middle of the sheet, about 0.15 steps a tick, half a step to a step and a half deep. It stays
/// far enough inside for the footprint to be whole.
inline Vec3 tool_at(const Scene& scene, long tick) {
    const double mid = (scene.side - 1) / 2.0, room = mid - scene.reach() - 2;
    const double t = static_cast<double>(tick) * 0.15 / room;
    const double i = mid + room * std::sin(t), j = mid + room * std::sin(0.618 * t + 1);
    const test::Point p = wave(i, j);
    return {p[0], p[1], p[2] - static_cast<float>(1 + 0.5 * std::sin(static_cast<double>(tick) / 50))};
}

}  // namespace dgm::bench
