// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/contact.cpp
// Layer `contact`: the area each sample stands for, and its freedom to move.
#include <algorithm>
#include <cmath>

#include "geometry/layers/layers.h"
#include "model/layer_names.h"

namespace dgm::bake {

model::Layer make_contact(const SampledChart& chart, std::span<const Vec3d> local) {
    std::vector<double> area(local.size(), 0.0);
    for (const Face& f : chart.faces()) {
        const double third = length(cross(local[f[1]] - local[f[0]], local[f[2]] - local[f[0]])) / 6;
        for (std::uint32_t s : f) area[s] += third;
    }
    // Border samples have no entry: their area goes to the nearest grid sample of the surface along the strip.
    const std::size_t grid = chart.grid_count();
    std::vector<std::uint32_t> owner(local.size(), kNone);
    for (std::uint32_t s = 0; s < grid; ++s)
        if (chart.on_surface(s)) owner[s] = s;
    for (bool changed = true; changed;) {
        changed = false;
        for (const Face& f : chart.strip)
            for (std::uint32_t s : f)
                for (std::uint32_t to : f)
                    if (owner[s] == kNone && owner[to] != kNone) {
                        owner[s] = owner[to];
                        changed = true;
                    }
    }
    model::Layer layer = empty_layer(model::layers::kContact, model::ElementType::kF32, {chart.m, chart.n, 2});
    const auto out = values<float>(layer);
    for (std::size_t s = grid; s < local.size(); ++s) {
        std::size_t to = owner[s];
        if (to == kNone) {  // a chart so thin that no grid sample lies on it
            const Vec2d uv = chart.border_uv[s - grid];
            to = static_cast<std::size_t>(std::lround(uv.x * (chart.m - 1))) * chart.n +
                 static_cast<std::size_t>(std::lround(uv.y * (chart.n - 1)));
        }
        area[to] += area[s];
    }
    for (std::size_t s = 0; s < grid; ++s) {
        out[2 * s] = static_cast<float>(area[s]);
        out[2 * s + 1] = 1.0f;
    }
    return layer;
}

}  // namespace dgm::bake
