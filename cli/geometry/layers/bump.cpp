// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/bump.cpp
// Makes layer `bump`: the height of the source over the grid surface, along the decoded normal.
#include <algorithm>
#include <cmath>

#include "geometry/fit/closest_samples.h"
#include "geometry/layers/fit_layers.h"
#include "geometry/layers/image_lookup.h"
#include "geometry/layers/layers.h"
#include "geometry/metrics/grid_point.h"
#include "model/half.h"
#include "model/layer_names.h"

namespace dgm::bake {
namespace {

/// Height of the source over the grid surface at each texel of a rows x cols layer.
/// @param at  the point of the source at each texel
std::vector<double> heights_over_grid(const LayerInput& in, const StoredPositions& positions,
                                      const StoredNormals& normals, const SampleGrid& at, std::uint32_t rows,
                                      std::uint32_t cols) {
    const SampledChart& chart = in.chart;
    const TriMesh& mesh = chart.disk->mesh;
    std::vector<double> height(std::size_t{rows} * cols, 0.0);
    for (std::uint32_t i = 0; i < rows; ++i)
        for (std::uint32_t j = 0; j < cols; ++j) {
            const std::size_t t = std::size_t{i} * cols + j;
            if (at.samples[t].face == kNone) continue;
            const double x = static_cast<double>(i) * (chart.m - 1) / std::max(1u, rows - 1),
                         y = static_cast<double>(j) * (chart.n - 1) / std::max(1u, cols - 1);
            const auto p = grid_point(
                x, y, chart.m, chart.n, [&](std::uint32_t r, std::uint32_t c) { return chart.has_quad(r, c); },
                [&](std::uint32_t r, std::uint32_t c) -> unsigned {
                    return chart.diagonals[std::size_t{r} * (chart.n - 1) + c];
                });
            if (!p) continue;
            if (!in.fitted && x == std::floor(x) && y == std::floor(y)) continue;  // a sample: on the surface
            Vec3d grid, normal;
            for (std::size_t k = 0; k < 3; ++k) {
                grid += positions.local[p->sample[k]] * p->b[k];
                normal += normals.decoded[p->sample[k]] * p->b[k];
            }
            normal = normalized(normal, normals.decoded[p->sample[0]]);
            const Vec3d truth = local_position(in, at.samples[t]);
            height[t] = in.fitted ? height_over(grid, normal, truth, normal_of_face(mesh, at.samples[t].face))
                                  : dot(truth - grid, normal);
        }
    return height;
}

/// Adds the height maps of the materials; returns the largest height.
double add_height_maps(const LayerInput& in, const SampleGrid& at, std::span<double> height) {
    const TriMesh& mesh = in.chart.disk->mesh;
    // -bm is the height from black to white in source units; at 1, MTL's default, the file does not say: 1 % of the
    // diagonal.
    const auto full_range = [&](double bm) { return bm == 1 ? 0.01 * in.frame.diagonal : bm; };
    double largest = 0;
    for (std::size_t t = 0; t < height.size(); ++t) {
        const SurfaceSample& from = at.samples[t];
        if (from.face == kNone) continue;
        const std::uint32_t material = mesh.face_materials.empty() ? kNone : mesh.face_materials[from.face];
        if (material < in.images.height.size() && in.images.height[material] && !mesh.corner_uvs.empty()) {
            Vec2d uv;
            for (int k = 0; k < 3; ++k) uv = uv + mesh.corner_uvs[3 * from.face + k] * from.b[k];
            height[t] +=
                (lookup(*in.images.height[material], uv) - 0.5) * full_range(mesh.materials[material].bump_scale);
        }
        largest = std::max(largest, std::abs(height[t]));
    }
    return largest;
}

/// The unit that heights are stored in.
double bump_scale(double diagonal, double largest) {
    // In source units where half precision holds them; else in units of `scale`, so that a mesh of 1e-9 keeps its
    // relief.
    double scale = largest > model::kHalfMax || diagonal < 1 ? std::ldexp(1, std::ilogb(diagonal)) : 1.0;
    if (largest / scale > model::kHalfMax) {  // a height map beyond all measure
        scale = std::ldexp(1, std::ilogb(largest / model::kHalfMax));
        if (largest / scale > model::kHalfMax) scale *= 2;
    }
    return scale;
}

}  // namespace

model::Layer make_bump(const LayerInput& in, const StoredPositions& positions, const StoredNormals& normals,
                       std::span<const MatchedPoint> points) {
    const SampledChart& chart = in.chart;
    const TriMesh& mesh = chart.disk->mesh;
    const std::uint32_t rows = in.bump_size ? in.bump_size->first : in.fine.m,
                        cols = in.bump_size ? in.bump_size->second : in.fine.n;
    const bool same = rows == in.fine.m && cols == in.fine.n;
    const SampleGrid own = same        ? SampleGrid{}
                           : in.fitted ? closest_samples(chart, rows, cols)
                                       : rasterize(mesh.faces, chart.uv, rows, cols);
    const SampleGrid& at = same ? in.fine : own;
    std::vector<double> height = heights_over_grid(in, positions, normals, at, rows, cols);
    if (!points.empty()) fit_bump(in, points, positions, normals, rows, cols, height);

    const double largest = add_height_maps(in, at, height);
    model::Layer layer = empty_layer(model::layers::kBump, model::ElementType::kF16, {rows, cols});
    const double scale = bump_scale(in.frame.diagonal, largest);
    layer.attributes["scale"] = std::vector<double>{scale};
    const auto out = values<std::uint16_t>(layer);
    for (std::size_t t = 0; t < height.size(); ++t) out[t] = model::half_bits(static_cast<float>(height[t] / scale));
    return layer;
}

}  // namespace dgm::bake
