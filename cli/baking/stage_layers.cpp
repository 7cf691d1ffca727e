// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/stage_layers.cpp
// Turns samples into the layers of the file.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "baking/materials.h"
#include "baking/stage_log.h"
#include "baking/stages.h"
#include "geometry/fit/closest_samples.h"
#include "model/layer_names.h"

namespace dgm::bake {
namespace {

using Shape = std::pair<std::uint32_t, std::uint32_t>;

/// The texture's size within options.texture_bytes, which charts share by area, and options.texel_length.
Shape limited_texture(Shape shape, const Repaired& source, std::size_t c, const BakeOptions& options) {
    constexpr double kTexelBytes = 4;
    const double texels = static_cast<double>(shape.first) * shape.second;
    double most = texels;
    if (options.texture_bytes) {
        const double area = std::accumulate(source.areas.begin(), source.areas.end(), 0.0);
        const double share = area > 0 ? source.areas[c] / area : 1 / static_cast<double>(source.areas.size());
        most = std::min(most, share * static_cast<double>(*options.texture_bytes) / kTexelBytes);
    }
    if (options.texel_length) {
        const double side = source.frame.diagonal / *options.texel_length;
        most = std::min(most, source.areas[c] * side * side);
    }
    const double scale = std::sqrt(most / texels);
    if (!(scale < 1)) return shape;
    const auto shrunk = [&](std::uint32_t side) {
        return std::max<std::uint32_t>(1, static_cast<std::uint32_t>(std::floor(side * scale)));
    };
    return {shrunk(shape.first), shrunk(shape.second)};
}

}  // namespace

Layered store_layers(const Repaired& source, const Fitted& fitted, std::span<const std::string> names,
                     const BakeOptions& options, bool u16, const model::Progress& progress) {
    Layered out;
    const bool moved = options.fit != Fit::kSample;
    for (std::size_t c = 0; c < fitted.charts.size(); ++c) {
        const model::Progress part = part_of(progress, "layers", c, fitted.charts.size());
        part.update("layers", 0);
        const SampledChart& chart = fitted.charts[c].chart;
        const StoredFrame stored = choose_frame(source.frame, chart, u16);
        SampleGrid fine;  // read by bump and texture alone
        if (wants(names, model::layers::kBump) || wants(names, model::layers::kTexture))
            fine = moved ? closest_samples(chart, 2 * chart.m - 1, 2 * chart.n - 1)
                         : rasterize(chart.disk->mesh.faces, chart.uv, 2 * chart.m - 1, 2 * chart.n - 1);
        chart.disk.drop_index();  // nobody asks for it again
        LayerInput in{chart, source.frame, stored, source.images, fine, std::nullopt, moved, std::nullopt};
        if (options.texture_size) in.texture_size = {options.texture_size->rows, options.texture_size->cols};
        if (options.bump_size) in.bump_size = {options.bump_size->rows, options.bump_size->cols};
        in.texture_size = limited_texture(texture_shape(in), source, c, options);
        ChartLayers made = make_layers(in, names, part);
        out.worst_quantisation = std::max(out.worst_quantisation, made.worst_quantisation);
        if (options.metres_per_unit && options.material)
            add_material(made.chart, *options.metres_per_unit, numbers_of(*options.material));
        else if (options.metres_per_unit)
            add_material(made.chart, *options.metres_per_unit, {});
        out.charts.push_back(std::move(made.chart));
    }
    return out;
}

}  // namespace dgm::bake
