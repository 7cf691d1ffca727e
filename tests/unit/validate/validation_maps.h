// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/validate/validation_maps.h
// A good file to break: a tube closed by a seam with every layer, and a free chart with a border strip.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "unit/geometry/metrics/test_charts.h"

namespace dgm::test {

inline constexpr std::uint32_t kTubeRows = 12, kTubeCols = 11;
inline constexpr double kTubeRadius = 0.5, kTubeLength = 2;

/// Tube along z, slit along column 0 = column 10, at offset (100, 0, 0). The prism through its samples has ten flat
/// sides, so areas, boxes and radii follow from chord and step.
inline model::Chart tube_chart() {
    using model::ElementType;
    constexpr std::uint32_t m = kTubeRows, n = kTubeCols;
    model::Chart chart;
    chart.rows = m;
    chart.cols = n;
    chart.method = "tutte";
    chart.offset = {100, 0, 0};
    std::vector<float> xyz;
    std::vector<std::int16_t> normals;
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            const double angle = 2 * std::numbers::pi * (j % (n - 1)) / (n - 1);
            const double x = std::cos(angle), y = std::sin(angle), sum = std::abs(x) + std::abs(y);
            xyz.insert(xyz.end(), {static_cast<float>(kTubeRadius * x), static_cast<float>(kTubeRadius * y),
                                   static_cast<float>(kTubeLength * (m - 1 - i) / (m - 1))});
            normals.push_back(static_cast<std::int16_t>(std::lround(32767 * x / sum)));
            normals.push_back(static_cast<std::int16_t>(std::lround(32767 * y / sum)));
        }
    const auto at = [&](std::uint32_t i, std::uint32_t j, int k) {
        return xyz[3 * (i * n + j) + static_cast<unsigned>(k)];
    };
    std::array<float, 3> low{9, 9, 9}, high{-9, -9, -9};
    for (std::size_t k = 0; k < xyz.size(); ++k) {
        low[k % 3] = std::min(low[k % 3], xyz[k]);
        high[k % 3] = std::max(high[k % 3], xyz[k]);
    }
    chart.bbox = {100.0 + low[0], low[1], low[2], 100.0 + high[0], high[1], high[2]};

    // 11 x 10 quads: 2 x 2 leaf tiles and the root.
    std::vector<float> boxes;
    const auto add_box = [&](std::uint32_t i0, std::uint32_t i1, std::uint32_t j0, std::uint32_t j1) {
        std::array<float, 6> box{9, 9, 9, -9, -9, -9};
        for (std::uint32_t i = i0; i <= i1; ++i)
            for (std::uint32_t j = j0; j <= j1; ++j)
                for (int k = 0; k < 3; ++k) {
                    float& lo = box[static_cast<unsigned>(k)];
                    float& hi = box[static_cast<unsigned>(k) + 3];
                    lo = std::min(lo, at(i, j, k));
                    hi = std::max(hi, at(i, j, k));
                }
        boxes.insert(boxes.end(), box.begin(), box.end());
    };
    add_box(0, 8, 0, 8);
    add_box(0, 8, 8, 10);
    add_box(8, 11, 0, 8);
    add_box(8, 11, 8, 10);
    add_box(0, 11, 0, 10);

    const double chord = 2 * kTubeRadius * std::sin(std::numbers::pi / (n - 1)), step = kTubeLength / (m - 1);
    std::vector<float> cover(m * n, static_cast<float>(std::hypot(chord, step) * (1 + 1e-6))), deformation, contact;
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            deformation.insert(deformation.end(),
                               {static_cast<float>(step * step), 0.f, static_cast<float>(chord * chord), 1.f});
            const double share = (i % (m - 1) == 0 ? 0.5 : 1.0) * (j % (n - 1) == 0 ? 0.5 : 1.0);
            contact.insert(contact.end(), {static_cast<float>(share * chord * step), 1.f});
        }
    std::vector<std::uint32_t> seams;
    for (std::uint32_t i = 0; i < m; ++i) seams.insert(seams.end(), {i * n, i * n + n - 1});

    auto& layers = chart.layers;
    layers.push_back(make_layer<float>("geometry", ElementType::kF32, {m, n, 3}, xyz));
    layers.push_back(make_layer<std::int16_t>("normal", ElementType::kI16, {m, n, 2}, normals));
    layers.push_back(
        make_layer<std::uint8_t>("texture", ElementType::kU8, {2, 3, 4}, std::vector<std::uint8_t>(24, 200)));
    layers.push_back(make_layer<std::uint16_t>("bump", ElementType::kF16, {2, 2}, {0, 0x3c00, 0x8000, 0x0001}));
    layers.push_back(make_layer<float>("collision", ElementType::kF32, {5, 6}, boxes));
    layers.back().attributes["levels"] = std::vector<std::uint32_t>{2, 2, 1, 1};
    layers.push_back(make_layer<float>("cover", ElementType::kF32, {m, n}, cover));
    layers.push_back(make_layer<float>("deformation", ElementType::kF32, {m, n, 4}, deformation));
    layers.push_back(make_layer<float>("contact", ElementType::kF32, {m, n, 2}, contact));
    layers.push_back(make_layer<float>("material", ElementType::kF32, {7}, {1e-3f, 200, 0.3f, 1e-3f, 2e4f, 5, 0}));
    layers.front().attributes["metres_per_unit"] = std::vector<double>{1e-3};
    layers.push_back(make_layer<std::uint32_t>("seams", ElementType::kU32, {m, 2}, seams));
    layers.push_back(make_layer<std::uint8_t>("diagonals", ElementType::kU8, {m - 1, n - 1},
                                              std::vector<std::uint8_t>((m - 1) * (n - 1), 1)));
    return chart;
}

/// 3 x 3 grid in the plane z = 0 with corner (2, 2) off the surface; the notch is closed by one border sample.
inline model::Chart free_chart() {
    using model::ElementType;
    model::Chart chart;
    chart.rows = chart.cols = 3;
    chart.method = "lscm";
    chart.domain = model::Domain::kFree;
    chart.bbox = {0, 0, 0, 2, 2, 0};
    std::vector<float> xyz;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) xyz.insert(xyz.end(), {static_cast<float>(i), static_cast<float>(j), 0.f});
    auto& layers = chart.layers;
    layers.push_back(make_layer<float>("geometry", ElementType::kF32, {3, 3, 3}, xyz));
    layers.push_back(make_layer<std::uint8_t>("mask", ElementType::kU8, {3, 3}, {1, 1, 1, 1, 1, 1, 1, 1, 0}));
    layers.push_back(make_layer<float>("border_uv", ElementType::kF32, {1, 2}, {0.875f, 0.75f}));
    layers.push_back(make_layer<float>("border_geometry", ElementType::kF32, {1, 3}, {1.75f, 1.5f, 0.f}));
    layers.push_back(make_layer<std::uint32_t>("border_faces", ElementType::kU32, {2, 3}, {4, 7, 9, 4, 9, 5}));
    return chart;
}

inline model::MapSet good_maps() {
    model::MapSet maps;
    maps.generator = "hand";
    maps.source_name = "tube.obj";
    maps.charts = {tube_chart(), free_chart()};
    maps.report_json = R"({"charts":[{"method":"tutte","domain":"square","rows":12,"cols":11,)"
                       R"("map_topology":{"components":1,"boundary_loops":2,"genus":0}},)"
                       R"({"method":"lscm","domain":"free","rows":3,"cols":3,)"
                       R"("map_topology":{"components":1,"boundary_loops":1,"genus":0}}],)"
                       R"("error":{"rms":0.001,"hausdorff":0.002,"diagonal":100}})";
    return maps;
}

}  // namespace dgm::test
