// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/cloth_shapes.h
// Sheets and tubes to try cloth on, in metres.
#pragma once
#include <dgm/cloth.h>
#include <gtest/gtest.h>

#include <numbers>
#include <utility>
#include <vector>

#include "cloth/cloth_impl.h"
#include "contact_shapes.h"
#include "exact_shapes.h"

namespace dgm::test {

inline constexpr float kG = 9.81f;

/// rows x cols samples on [0, length] x [0, width] in the plane z = 0; rows along x.
inline ChartSpec sheet_chart(std::uint32_t rows, std::uint32_t cols, double length, double width) {
    return grid_chart(rows, cols, [=](double i, double j) {
        return Point{float(length * i / (rows - 1)), float(width * j / (cols - 1)), 0};
    });
}
/// The same in a vertical plane: row 0 on top, at z = 0.
inline ChartSpec curtain_chart(std::uint32_t rows, std::uint32_t cols, double length, double width) {
    return grid_chart(rows, cols, [=](double i, double j) {
        return Point{float(width * j / (cols - 1)), 0, float(-length * i / (rows - 1))};
    });
}
/// A tube around the z axis, sewn along a line; `flare`: how much wider it is at the last row.
inline ChartSpec skirt_chart(std::uint32_t rows, std::uint32_t cols, double radius, double length, double flare) {
    SeamPairs seams;
    for (std::uint32_t i = 0; i < rows; ++i) seams.push_back({i * cols, i * cols + cols - 1});
    return grid_chart(
        rows, cols,
        [=](double i, double j) {
            const double t = j == cols - 1 ? 0 : 2 * std::numbers::pi * j / (cols - 1);
            const double r = radius * (1 + flare * i / (rows - 1));
            return Point{float(r * std::cos(t)), float(r * std::sin(t)), float(-length * i / (rows - 1))};
        },
        seams);
}

struct Drape {
    State state;
    Cloth cloth;
    ClothStep how;
    std::vector<Pin> pins;
    explicit Drape(const ChartSpec& chart, ClothOptions options = {})
        : state(make_state(chart)), cloth(make(state, options)) {
        how.gravity = {0, 0, -kG};
    }
    static Cloth make(const State& state, ClothOptions o) {
        if (o.metres_per_unit == 0) o.metres_per_unit = 1;
        auto made = Cloth::create(state, o);
        EXPECT_TRUE(made.ok()) << made.error().message;
        return std::move(made).value();
    }
    void pin(std::uint32_t sample) { pins.push_back({sample, state.positions()[sample]}); }
    /// Holds whole rows where they are.
    void pin_rows(std::uint32_t first, std::uint32_t count) {
        for (std::uint32_t k = first * state.cols(); k < (first + count) * state.cols(); ++k) pin(k);
    }
    ClothReport run(int frames) {
        ClothReport r;
        for (int k = 0; k < frames; ++k) {
            how.pins = pins;
            auto done = step(state, cloth, how);
            EXPECT_TRUE(done.ok()) << done.error().message;
            r = done.value();
            EXPECT_FALSE(r.clamped);
        }
        return r;
    }
    /// In metres, not rounded to floats.
    detail::Double3 at(std::uint32_t i, std::uint32_t j) const {
        return cloth.impl()->place(cloth.impl()->spot_of(i * state.cols() + j));
    }
    detail::Double3 mean_of_row(std::uint32_t i) const {
        detail::Double3 sum;
        for (std::uint32_t j = 0; j < state.cols(); ++j) sum = sum + at(i, j);
        return (1.0 / state.cols()) * sum;
    }
};

}  // namespace dgm::test
