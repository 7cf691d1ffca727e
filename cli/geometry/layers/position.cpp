// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/position.cpp
// Layer `geometry` (eq. 1) and the frame it is stored in.
#include <algorithm>
#include <cmath>

#include "geometry/layers/layers.h"
#include "geometry/mesh/infinity.h"
#include "model/layer_names.h"

namespace dgm::bake {
namespace {

constexpr double kFarChart = 1000;  // of the chart's own size: at 1000 a float resolves 6e-5 of it
constexpr double kFar = 8;          // diagonals from the origin; at 8 a float still resolves 5e-7 of the diagonal

struct Box {
    Vec3d centre;
    double diagonal = 0;
};

/// Bounding box of the samples on the surface, in the normalised frame.
Box box_of(const SampledChart& chart) {
    Vec3d low{kInfinity, kInfinity, kInfinity}, high = -low;
    for (std::size_t s = 0; s < chart.positions.size(); ++s) {
        if (!chart.on_surface(s)) continue;
        for (int k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], chart.positions[s][k]);
            high[k] = std::max(high[k], chart.positions[s][k]);
        }
    }
    if (!is_finite(low)) return {};
    return {(low + high) * 0.5, length(high - low)};
}

}  // namespace

StoredFrame choose_frame(const Frame& frame, const SampledChart& chart, bool quantised) {
    StoredFrame out;
    const double far = std::max({std::abs(frame.centre.x), std::abs(frame.centre.y), std::abs(frame.centre.z)});
    const bool keep_origin = far <= kFar * frame.diagonal;
    if (!quantised) {
        const Box box = box_of(chart);
        const Vec3d origin = keep_origin ? Vec3d{} : frame.centre, centre = frame.centre + box.centre * frame.diagonal;
        const bool is_far = length(centre - origin) > kFarChart * box.diagonal * frame.diagonal && box.diagonal > 0;
        const Vec3d& from = is_far ? centre : origin;
        out.offset = {from.x, from.y, from.z};
        return out;
    }
    out.quantised = true;
    const Lattice lattice = chart.lattice ? *chart.lattice : lattice_around(chart);
    for (int k = 0; k < 3; ++k) {
        out.offset[k] = frame.centre[k] + frame.diagonal * lattice.low[k];
        out.scale[k] = lattice.step * frame.diagonal;
    }
    return out;
}

StoredPositions store_positions(const LayerInput& in) {
    const SampledChart& chart = in.chart;
    const StoredFrame& stored = in.stored;
    StoredPositions out;
    const std::size_t grid = chart.grid_count(), extra = chart.positions.size() - grid;
    out.geometry =
        empty_layer(model::layers::kGeometry, stored.quantised ? model::ElementType::kU16 : model::ElementType::kF32,
                    {chart.m, chart.n, 3});
    if (extra > 0)
        out.border_geometry = empty_layer(model::layers::kBorderGeometry, model::ElementType::kF32, {extra, 3});
    out.local.resize(chart.positions.size());
    for (std::size_t s = 0; s < chart.positions.size(); ++s) {
        const std::size_t from = chart.representative[s];
        if (from != s) {
            out.local[s] = out.local[from];
        } else if (!chart.on_surface(s)) {
            continue;
        }
        for (int k = 0; k < 3; ++k) {
            // source - offset, without forming a large source coordinate first
            const double relative =
                (in.frame.centre[k] - stored.offset[k]) + in.frame.diagonal * chart.positions[from][k];
            if (s >= grid) {
                const auto value = static_cast<float>(relative);
                values<float>(*out.border_geometry)[3 * (s - grid) + k] = value;
                out.local[s][k] = value;
            } else if (stored.quantised) {
                const double code = std::clamp(std::round(relative / stored.scale[k]), 0.0, Lattice::kCodes);
                values<std::uint16_t>(out.geometry)[3 * s + k] = static_cast<std::uint16_t>(code);
                out.local[s][k] = stored.scale[k] * code;
            } else {
                const auto value = static_cast<float>(relative);
                values<float>(out.geometry)[3 * s + k] = value;
                out.local[s][k] = value;
            }
        }
    }
    if (stored.quantised) out.worst_quantisation = stored.scale[0] / 2;
    return out;
}

}  // namespace dgm::bake
