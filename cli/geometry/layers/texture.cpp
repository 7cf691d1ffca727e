// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/texture.cpp
// Layer `texture`: a fabric image, the materials' textures, vertex colours or material colours, in this order.
#include <algorithm>
#include <cmath>

#include "geometry/fit/closest_samples.h"
#include "geometry/layers/dilate.h"
#include "geometry/layers/fit_layers.h"
#include "geometry/layers/image_lookup.h"
#include "geometry/layers/layers.h"
#include "model/layer_names.h"

namespace dgm::bake {
namespace {

using model::Rgba8;

std::uint8_t to_byte(double x) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(x, 0.0, 255.0)));
}

/// Colour of a point of the disk by its corner attributes and material.
Rgba8 colour_at(const LayerInput& in, const SurfaceSample& at) {
    const TriMesh& mesh = in.chart.disk->mesh;
    const std::uint32_t material = mesh.face_materials.empty() ? kNone : mesh.face_materials[at.face];
    if (material < in.images.colour.size() && in.images.colour[material] && !mesh.corner_uvs.empty()) {
        Vec2d uv;
        for (int k = 0; k < 3; ++k) uv = uv + mesh.corner_uvs[3 * at.face + k] * at.b[k];
        return lookup(*in.images.colour[material], uv);
    }
    if (!mesh.corner_colours.empty()) {
        double sum[4] = {0, 0, 0, 0};
        for (int k = 0; k < 3; ++k) {
            const Rgba8 c = mesh.corner_colours[3 * at.face + k];
            sum[0] += at.b[k] * c.r;
            sum[1] += at.b[k] * c.g;
            sum[2] += at.b[k] * c.b;
        }
        return {to_byte(sum[0]), to_byte(sum[1]), to_byte(sum[2]), 255};  // alpha is paint for stiffness
    }
    return material < mesh.materials.size() ? mesh.materials[material].diffuse : Rgba8{};
}

bool has_colour(const LayerInput& in) {
    const TriMesh& mesh = in.chart.disk->mesh;
    if (in.images.fabric || !mesh.corner_colours.empty()) return true;
    for (std::uint32_t material : mesh.face_materials)
        if (material < mesh.materials.size() &&
            (mesh.materials[material].diffuse != Rgba8{} || in.images.colour[material]))
            return true;
    return false;
}

}  // namespace

bool has_texture(const LayerInput& in) {
    return has_colour(in) && !in.images.fabric;
}

std::pair<std::uint32_t, std::uint32_t> texture_shape(const LayerInput& in) {
    const bool has_image = in.images.fabric || std::any_of(in.images.colour.begin(), in.images.colour.end(),
                                                           [](const auto& image) { return image.has_value(); });
    // Pictures get twice the grid's resolution, plain colours the grid's own.
    if (in.texture_size) return *in.texture_size;
    return has_image ? std::pair{in.fine.m, in.fine.n} : std::pair{in.chart.m, in.chart.n};
}

std::optional<model::Layer> make_texture(const LayerInput& in, std::span<const MatchedPoint> points) {
    if (!has_colour(in)) return std::nullopt;
    const auto [rows, cols] = texture_shape(in);
    model::Layer layer = empty_layer(model::layers::kTexture, model::ElementType::kU8, {rows, cols, 4});
    const auto rgba = values<std::uint8_t>(layer);
    const auto put = [&](std::size_t t, Rgba8 c) {
        rgba[4 * t] = c.r;
        rgba[4 * t + 1] = c.g;
        rgba[4 * t + 2] = c.b;
        rgba[4 * t + 3] = c.a;
    };
    if (in.images.fabric) {
        for (std::uint32_t i = 0; i < rows; ++i)
            for (std::uint32_t j = 0; j < cols; ++j)
                put(std::size_t{i} * cols + j, lookup(*in.images.fabric, {(j + 0.5) / cols, 1 - (i + 0.5) / rows}));
        return layer;
    }
    const bool same = rows == in.fine.m && cols == in.fine.n;
    const SampleGrid own = same        ? SampleGrid{}
                           : in.fitted ? closest_samples(in.chart, rows, cols)
                                       : rasterize(in.chart.disk->mesh.faces, in.chart.uv, rows, cols);
    const SampleGrid& grid = same ? in.fine : own;
    std::vector<char> covered(grid.samples.size(), 0);
    for (std::size_t t = 0; t < grid.samples.size(); ++t) {
        if (grid.samples[t].face == kNone) continue;
        covered[t] = 1;
        put(t, colour_at(in, grid.samples[t]));
    }
    const std::vector<std::uint32_t> from = nearest_covered(covered, rows, cols);
    for (std::size_t t = 0; t < from.size(); ++t)
        if (from[t] != kNone && from[t] != t) std::copy_n(rgba.begin() + 4 * from[t], 4, rgba.begin() + 4 * t);
    if (points.empty()) return layer;
    std::vector<std::array<double, 4>> colours(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Rgba8 c = colour_at(in, points[k].at);
        colours[k] = {static_cast<double>(c.r), static_cast<double>(c.g), static_cast<double>(c.b),
                      static_cast<double>(c.a)};
    }
    fit_texture(in, points, colours, rows, cols, rgba);
    return layer;
}

}  // namespace dgm::bake
