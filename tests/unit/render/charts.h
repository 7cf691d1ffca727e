// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/render/charts.h
// Charts whose every value is known.
#pragma once
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>

#include "model/map_set.h"
#include "model/vec.h"

namespace dgm::render {

/// rows x cols samples of `place`, which gets (i, j); no other layers.
inline model::Chart chart_of(std::uint32_t rows, std::uint32_t cols,
                             const std::function<model::Vec3d(double, double)>& place) {
    model::Chart chart;
    chart.rows = rows;
    chart.cols = cols;
    chart.method = "uv";
    model::Layer geometry{"geometry", model::ElementType::kF32, {rows, cols, 3}, {}, {}, true};
    for (std::uint32_t i = 0; i < rows; ++i)
        for (std::uint32_t j = 0; j < cols; ++j) {
            const model::Vec3d p = place(i, j);
            const float stored[3] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
            const auto* bytes = reinterpret_cast<const std::byte*>(stored);
            geometry.bytes.insert(geometry.bytes.end(), bytes, bytes + sizeof stored);
        }
    chart.layers.push_back(std::move(geometry));
    return chart;
}

/// A hill over the unit square. (u, v) = (x, y) keeps faces counter-clockwise seen from above.
inline model::Chart hill(std::uint32_t rows, std::uint32_t cols) {
    return chart_of(rows, cols, [&](double i, double j) {
        const double x = i / (rows - 1.0), y = j / (cols - 1.0);
        return model::Vec3d{x, y, 0.3 * std::sin(3 * x) * std::cos(2 * y)};
    });
}

}  // namespace dgm::render
