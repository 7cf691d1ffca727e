// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/exact_shapes.h
// Charts whose samples have the same bits on every target: they are made with + - * / and square roots alone, since C
// libraries round sines each in its own way.
#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "dgm_builder.h"

namespace dgm::test {

struct Turn {
    double cosine, sine;
};
/// A way once around the unit circle for `t` in 0 .. 1, a quarter for each quarter of t.
inline Turn turn(double t) {
    const double quarter = std::floor(4 * t), s = 4 * t - quarter;
    const double c = (1 - s * s) / (1 + s * s), d = 2 * s / (1 + s * s);
    switch (static_cast<int>(quarter) % 4) {
        case 0:
            return {c, d};
        case 1:
            return {-d, c};
        case 2:
            return {-c, -d};
        default:
            return {d, -c};
    }
}
/// A smooth wave of period 1 and height 1.
inline double wave_of(double t) {
    const double x = t - std::floor(t);
    return 16 * x * x * (1 - x) * (1 - x);
}
inline Point point_of(double x, double y, double z) {
    return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
}

/// A sheet with a grid step near 1, bent so that no two distances are equal by symmetry.
inline Point bent_sheet(double i, double j) {
    return point_of(i, j + 0.01 * i, 1.5 * wave_of(i / 17) * wave_of(j / 23) + 0.02 * wave_of(i / 3 + j / 5));
}
/// Around the z axis in `cols` - 1 steps; its radius of about 6 waves along the axis.
inline std::function<Point(double, double)> bent_tube(std::uint32_t cols) {
    return [cols](double i, double j) {
        const Turn a = turn(j / (cols - 1));
        const double radius = 6 + wave_of(i / 19) + 0.3 * wave_of(2 * j / (cols - 1));
        return point_of(radius * a.cosine, radius * a.sine, 0.8 * i);
    };
}
/// The octahedral map of an uneven ball of radius about 10: the middle of the map is its top.
inline std::function<Point(double, double)> ball(std::uint32_t side) {
    return [side](double i, double j) {
        double x = 2 * i / (side - 1) - 1, y = 2 * j / (side - 1) - 1;
        const double z = 1 - std::fabs(x) - std::fabs(y);
        if (z < 0) {
            const double folded = (1 - std::fabs(y)) * (x < 0 ? -1 : 1);
            y = (1 - std::fabs(x)) * (y < 0 ? -1 : 1);
            x = folded;
        }
        const double length = std::sqrt(x * x + y * y + z * z);
        const double radius = 10 + wave_of(0.5 + x / (2 * length)) * wave_of(0.3 + z / (3 * length));
        return point_of(radius * x / length, 0.9 * radius * y / length, radius * z / length);
    };
}

/// Diagonals by chance.
inline void add_mixed_diagonals(ChartSpec& chart) {
    std::vector<std::uint8_t> bits(std::size_t{chart.rows - 1} * (chart.cols - 1));
    std::uint32_t random = 12345;
    for (std::uint8_t& bit : bits) {
        random = random * 1664525 + 1013904223;
        bit = static_cast<std::uint8_t>(random >> 31);
    }
    chart.add("diagonals", ElementType::kU8, {chart.rows - 1, chart.cols - 1}, bits);
}
/// Stiffness 0.25 .. 1 and mobility 0 .. 1, alike on columns 0 and cols - 1.
inline void add_paint(ChartSpec& chart) {
    std::vector<float> deformation, contact;
    for (std::uint32_t i = 0; i < chart.rows; ++i)
        for (std::uint32_t j = 0; j < chart.cols; ++j) {
            const double t = wave_of(2.0 * j / (chart.cols - 1)) * wave_of(i / 9.0);
            deformation.insert(deformation.end(), {1, 0, 1, static_cast<float>(1 - 0.75 * t)});
            contact.insert(contact.end(), {1, i < 2 ? 0.0f : static_cast<float>(1 - t * t)});
        }
    chart.add("deformation", ElementType::kF32, {chart.rows, chart.cols, 4}, deformation);
    chart.add("contact", ElementType::kF32, {chart.rows, chart.cols, 2}, contact);
}

}  // namespace dgm::test
