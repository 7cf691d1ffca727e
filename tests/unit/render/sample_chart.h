// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/render/sample_chart.h
// Charts with all layers, made from formulas.
#pragma once
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <dgm/grid.h>

#include "model/layer_names.h"
#include "model/map_set.h"
#include "model/octahedral.h"
#include "unit/geometry/metrics/test_charts.h"

namespace dgm::test {

/// Torus of radii 1 and 0.4 about the y axis, m x n samples, u around the tube and v around the axis; its opposite
/// sides are seams. Texture: 2 x 2 texels a sample step, rows below the middle red, above green, every 16th column
/// black.
inline model::Chart torus_chart(std::uint32_t m, std::uint32_t n) {
    using model::ElementType;
    model::Chart chart;
    chart.rows = m;
    chart.cols = n;
    chart.method = "formula";
    chart.bbox = {-1.4, -0.4, -1.4, 1.4, 0.4, 1.4};
    std::vector<float> geometry, cover, deformation, contact;
    std::vector<std::int16_t> normals;
    std::vector<std::uint8_t> diagonals;
    const double du = 2 * std::numbers::pi / (m - 1), dv = 2 * std::numbers::pi / (n - 1);
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            const double a = du * (i % (m - 1)), b = dv * (j % (n - 1));  // copies of a seam sample get equal bits
            const double ring = 1 + 0.4 * std::cos(a);
            geometry.insert(geometry.end(),
                            {static_cast<float>(ring * std::cos(b)), static_cast<float>(0.4 * std::sin(a)),
                             static_cast<float>(ring * std::sin(b))});
            const auto code =
                model::encode_octahedral({std::cos(a) * std::cos(b), std::sin(a), std::cos(a) * std::sin(b)});
            normals.insert(normals.end(), code.begin(), code.end());
            cover.push_back(static_cast<float>(0.5 * std::hypot(0.4 * du, ring * dv)));
            deformation.insert(deformation.end(), {static_cast<float>(0.16 * du * du), 0.0f,
                                                   static_cast<float>(ring * ring * dv * dv), 1.0f});
            contact.insert(contact.end(), {static_cast<float>(0.4 * du * ring * dv), j < n / 2 ? 1.0f : 0.0f});
            if (i + 1 < m && j + 1 < n) diagonals.push_back((i + j) % 2);
        }
    chart.layers.push_back(make_layer("geometry", ElementType::kF32, {m, n, 3}, geometry));
    chart.layers.push_back(make_layer("normal", ElementType::kI16, {m, n, 2}, normals));

    const std::uint32_t mt = 2 * (m - 1) + 1, nt = 2 * (n - 1) + 1;
    std::vector<std::uint8_t> texture;
    for (std::uint32_t i = 0; i < mt; ++i)
        for (std::uint32_t j = 0; j < nt; ++j) {
            const bool line = j % 16 == 0, top = 2 * i < mt;
            texture.insert(texture.end(), {static_cast<std::uint8_t>(line || top ? 20 : 220),
                                           static_cast<std::uint8_t>(line || !top ? 30 : 190), 40, 255});
        }
    chart.layers.push_back(make_layer("texture", ElementType::kU8, {mt, nt, 4}, texture));
    // binary16 of 0, 1, -1 and 0.5
    std::vector<std::uint16_t> bump(std::size_t{m} * n, 0);
    bump[1] = 0x3c00;
    bump[2] = 0xbc00;
    bump[3] = 0x3800;
    chart.layers.push_back(make_layer("bump", ElementType::kF16, {m, n}, bump));

    std::vector<float> boxes;
    std::vector<std::uint32_t> levels;
    std::uint32_t rows = tile_count(m - 1), cols = tile_count(n - 1);
    for (std::uint32_t r = 0; r < rows; ++r)
        for (std::uint32_t c = 0; c < cols; ++c) {
            float low[3] = {9, 9, 9}, high[3] = {-9, -9, -9};
            for (std::uint32_t i = r * kTileQuads; i <= std::min(m - 1, (r + 1) * kTileQuads); ++i)
                for (std::uint32_t j = c * kTileQuads; j <= std::min(n - 1, (c + 1) * kTileQuads); ++j)
                    for (std::size_t k = 0; k < 3; ++k) {
                        low[k] = std::min(low[k], geometry[3 * sample_index(i, j, n) + k]);
                        high[k] = std::max(high[k], geometry[3 * sample_index(i, j, n) + k]);
                    }
            boxes.insert(boxes.end(), low, low + 3);
            boxes.insert(boxes.end(), high, high + 3);
        }
    levels = {rows, cols};
    chart.layers.push_back(make_layer("collision", ElementType::kF32, {std::uint64_t{rows} * cols, 6}, boxes));
    chart.layers.back().attributes["levels"] = levels;
    chart.layers.push_back(make_layer("cover", ElementType::kF32, {m, n}, cover));
    chart.layers.push_back(make_layer("deformation", ElementType::kF32, {m, n, 4}, deformation));
    chart.layers.push_back(make_layer("contact", ElementType::kF32, {m, n, 2}, contact));
    std::vector<std::uint32_t> seams;
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            const std::uint32_t home = (i % (m - 1)) * n + j % (n - 1), here = i * n + j;
            if (home != here) seams.insert(seams.end(), {home, here});
        }
    chart.layers.push_back(make_layer("seams", ElementType::kU32, {seams.size() / 2, 2}, seams));
    chart.layers.push_back(make_layer("diagonals", ElementType::kU8, {m - 1, n - 1}, diagonals));
    return chart;
}

/// Flat chart in the plane z = 0, x = v, y = u, of the free domain: samples within 0.42 of the middle are on the
/// surface; 24 border samples on that circle, joined among themselves by a fan's first triangles.
inline model::Chart disc_chart(std::uint32_t m) {
    using model::ElementType;
    model::Chart chart;
    chart.rows = chart.cols = m;
    chart.domain = model::Domain::kFree;
    chart.method = "formula";
    chart.bbox = {0.08, 0.08, 0, 0.92, 0.92, 0};
    std::vector<float> geometry, border_uv, border_geometry;
    std::vector<std::uint8_t> mask;
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < m; ++j) {
            const double u = i / (m - 1.0), v = j / (m - 1.0);
            geometry.insert(geometry.end(), {static_cast<float>(v), static_cast<float>(u), 0.0f});
            mask.push_back(std::hypot(u - 0.5, v - 0.5) < 0.42 ? 1 : 0);
        }
    std::vector<std::uint32_t> faces;
    constexpr std::uint32_t kBorder = 24;
    for (std::uint32_t b = 0; b < kBorder; ++b) {
        const double angle = 2 * std::numbers::pi * b / kBorder;
        const auto u = static_cast<float>(0.5 + 0.42 * std::sin(angle)),
                   v = static_cast<float>(0.5 + 0.42 * std::cos(angle));
        border_uv.insert(border_uv.end(), {u, v});
        border_geometry.insert(border_geometry.end(), {v, u, 0.0f});
        if (b >= 1 && b + 1 < 5) faces.insert(faces.end(), {m * m, m * m + b, m * m + b + 1});
    }
    chart.layers.push_back(make_layer("geometry", ElementType::kF32, {m, m, 3}, geometry));
    chart.layers.push_back(make_layer("mask", ElementType::kU8, {m, m}, mask));
    chart.layers.push_back(make_layer("border_uv", ElementType::kF32, {kBorder, 2}, border_uv));
    chart.layers.push_back(make_layer("border_geometry", ElementType::kF32, {kBorder, 3}, border_geometry));
    chart.layers.push_back(make_layer("border_faces", ElementType::kU32, {faces.size() / 3, 3}, faces));
    return chart;
}

/// The chart's surface alone, which dgm-validate passes; made-up values of the other layers it does not.
inline model::Chart surface_alone(model::Chart chart) {
    using namespace model::layers;
    std::erase_if(chart.layers, [](const model::Layer& layer) {
        return layer.name != kGeometry && layer.name != kSeams && layer.name != kDiagonals && layer.name != kMask &&
               !layer.name.starts_with("border_");
    });
    return chart;
}

}  // namespace dgm::test
