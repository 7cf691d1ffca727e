// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/chart_colours.cpp
#include "render/chart_colours.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/canvas.h"
#include "render/colour.h"
#include "render/layer_picture.h"
#include "render/percentile.h"

namespace dgm::render {
namespace {

/// All numbers, without their signs.
std::vector<double> sizes_of(std::span<const SurfaceValues> charts, std::vector<double> SurfaceValues::*field) {
    std::vector<double> out;
    for (const SurfaceValues& chart : charts)
        for (const double value : chart.*field)
            if (std::isfinite(value)) out.push_back(std::abs(value));
    return out;
}

const std::vector<double>& values_of(const SurfaceValues& values, Quantity quantity) {
    if (quantity == Quantity::kDistance) return values.distance;
    return quantity == Quantity::kArea ? values.area : values.angle;
}
}  // namespace

Scales scales_of(std::span<const SurfaceValues> charts, std::span<const double> source_distances) {
    constexpr double kShare = 0.99;
    Scales out;
    std::vector<double> sizes = sizes_of(charts, &SurfaceValues::distance);
    for (const double value : source_distances)
        if (std::isfinite(value)) sizes.push_back(std::abs(value));
    out.worst = sizes.empty() ? 0 : *std::max_element(sizes.begin(), sizes.end());
    out.distance = percentile(std::move(sizes), kShare);
    sizes = sizes_of(charts, &SurfaceValues::area);
    out.area = std::max(1.0, percentile(std::move(sizes), kShare));
    sizes = sizes_of(charts, &SurfaceValues::angle);
    out.angle = std::max(1.0, percentile(std::move(sizes), kShare));
    return out;
}

double table_place(Quantity quantity, double value, const Scales& scales) {
    const auto share = [&](double end) { return end > 0 ? std::clamp(value / end, -1.0, 1.0) : 0.0; };
    if (std::isnan(value)) return value;
    if (quantity == Quantity::kAngle) return std::max(0.0, share(scales.angle));
    return 0.5 + 0.5 * share(quantity == Quantity::kArea ? scales.area : scales.distance);
}

model::Rgba8 quantity_colour(Quantity quantity, double place) {
    return quantity == Quantity::kAngle ? render::sequential_colour(place) : render::diverging_colour(2 * place - 1);
}

formats::Image grid_picture(const model::Chart& chart, const SurfaceValues& values, Quantity quantity,
                            const Scales& scales) {
    formats::Image out = render::blank(chart.cols, chart.rows, render::kOffSurface);
    const std::vector<double>& all = values_of(values, quantity);
    for (std::size_t s = 0; s < out.pixels.size() && s < all.size(); ++s)
        if (!std::isnan(all[s])) out.pixels[s] = quantity_colour(quantity, table_place(quantity, all[s], scales));
    return out;
}

}  // namespace dgm::render
