// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/bump.cpp
// Layer `bump`: what the grid surface misses of the source, by height along the decoded normal.
#include <algorithm>
#include <cmath>

#include "geometry/layers/image_lookup.h"
#include "geometry/layers/layers.h"
#include "model/half.h"

namespace dgm::bake {

model::Layer make_bump(const LayerInput& in, const StoredPositions& positions, const StoredNormals& normals) {
    const SampledChart& chart = in.chart;
    const TriMesh& mesh = chart.disk.mesh;
    const std::uint32_t rows = in.fine.m, cols = in.fine.n, n = chart.n;
    // -bm is the height from black to white in source units; at 1, MTL's default, the file does not say: 1 % of the
    // diagonal.
    const auto full_range = [&](double bump_scale) { return bump_scale == 1 ? 0.01 * in.frame.diagonal : bump_scale; };
    model::Layer layer = empty_layer("bump", model::ElementType::kF16, {rows, cols});
    std::vector<double> height(std::size_t{rows} * cols, 0.0);
    double largest = 0;
    for (std::uint32_t i = 0; i < rows; ++i)
        for (std::uint32_t j = 0; j < cols; ++j) {
            const SurfaceSample& at = in.fine.samples[std::size_t{i} * cols + j];
            if (at.face == kNone) continue;
            // The two grid samples that this texel lies between: itself, the ends of an edge, or of the quad's
            // diagonal.
            const std::uint32_t i0 = i / 2, j0 = j / 2;
            std::size_t a = std::size_t{i0} * n + j0, b = std::size_t{i0 + i % 2} * n + j0 + j % 2;
            if (i % 2 == 1 && j % 2 == 1) {
                if (!chart.has_quad(i0, j0)) continue;
                if (chart.diagonals[std::size_t{i0} * (n - 1) + j0])
                    a = std::size_t{i0 + 1} * n + j0, b = std::size_t{i0} * n + j0 + 1;
            }
            if (!chart.on_surface(a) || !chart.on_surface(b)) continue;
            const Vec3d grid = (positions.local[a] + positions.local[b]) * 0.5;
            const Vec3d normal = normalized(normals.decoded[a] + normals.decoded[b], normals.decoded[a]);
            Vec3d truth = position_at(mesh, at);
            for (int k = 0; k < 3; ++k)
                truth[k] = (in.frame.centre[k] - in.stored.offset[k]) + in.frame.diagonal * truth[k];
            double h = i % 2 == 0 && j % 2 == 0 && !in.fitted ? 0.0 : dot(truth - grid, normal);
            const std::uint32_t material = mesh.face_materials.empty() ? kNone : mesh.face_materials[at.face];
            if (material < in.images.height.size() && in.images.height[material] && !mesh.corner_uvs.empty()) {
                Vec2d uv;
                for (int k = 0; k < 3; ++k) uv = uv + mesh.corner_uvs[3 * at.face + k] * at.b[k];
                h += (lookup(*in.images.height[material], uv) - 0.5) * full_range(mesh.materials[material].bump_scale);
            }
            height[std::size_t{i} * cols + j] = h;
            largest = std::max(largest, std::abs(h));
        }
    // In source units where half precision holds them; else in units of `scale`, so that a mesh of 1e-9 keeps its
    // relief.
    const double diagonal = in.frame.diagonal;
    const double scale = largest > model::kHalfMax || diagonal < 1 ? std::exp2(std::floor(std::log2(diagonal))) : 1.0;
    layer.attributes["scale"] = std::vector<double>{scale};
    const auto out = values<std::uint16_t>(layer);
    for (std::size_t t = 0; t < height.size(); ++t) out[t] = model::half_bits(static_cast<float>(height[t] / scale));
    return layer;
}

}  // namespace dgm::bake
