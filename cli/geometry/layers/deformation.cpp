// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/deformation.cpp
// Layer `deformation`: the first fundamental form per grid step and the stiffness factor of sigma.
#include <algorithm>

#include "geometry/layers/layers.h"
#include "model/layer_names.h"

namespace dgm::bake {
namespace {

/// Tangents X_i, X_j at grid samples: central differences, over a seam with the sample behind the mate as ghost.
class Tangents {
 public:
    Tangents(const SampledChart& chart, std::span<const Vec3d> local) : chart_(chart), local_(local) {
        copies_.resize(chart.grid_count(), {kNone, 0});
        std::vector<std::uint32_t> first(chart.grid_count(), kNone);
        if (chart.domain != layout::Domain::kSquare) return;
        for (std::uint32_t s = 0; s < chart.grid_count(); ++s) {
            const std::uint32_t rep = chart.representative[s];
            if (rep == s) continue;
            ++copies_[rep].count;
            copies_[rep].other = s;
        }
    }

    [[nodiscard]] Vec3d along_i(std::uint32_t i, std::uint32_t j) const { return along(i, j, i, chart_.m, true); }
    [[nodiscard]] Vec3d along_j(std::uint32_t i, std::uint32_t j) const { return along(i, j, j, chart_.n, false); }

 private:
    struct Copies {
        std::uint32_t other;
        std::uint32_t count;
    };

    [[nodiscard]] std::size_t at(std::uint32_t i, std::uint32_t j) const { return std::size_t{i} * chart_.n + j; }

    /// The sample one step beyond the border at s: one step inward from the only other copy of s; kNone elsewhere.
    [[nodiscard]] std::size_t ghost(std::size_t s) const {
        const std::uint32_t rep = chart_.representative[s];
        if (copies_[rep].count != 1) return kNone;
        const std::uint32_t mate = s == rep ? copies_[rep].other : rep;
        const std::uint32_t i = mate / chart_.n, j = mate % chart_.n;
        const bool row_side = i == 0 || i == chart_.m - 1, column_side = j == 0 || j == chart_.n - 1;
        if (row_side == column_side) return kNone;  // a corner has no one inward direction
        if (row_side) return at(i == 0 ? 1 : i - 1, j);
        return at(i, j == 0 ? 1 : j - 1);
    }

    [[nodiscard]] Vec3d along(std::uint32_t i, std::uint32_t j, std::uint32_t k, std::uint32_t size, bool rows) const {
        const std::size_t here = at(i, j), step = rows ? chart_.n : 1;
        std::size_t before = k > 0 ? here - step : ghost(here), after = k + 1 < size ? here + step : ghost(here);
        if (before != kNone && !chart_.on_surface(before)) before = kNone;
        if (after != kNone && !chart_.on_surface(after)) after = kNone;
        if (before != kNone && after != kNone) return (local_[after] - local_[before]) * 0.5;
        if (after != kNone) return local_[after] - local_[here];
        if (before != kNone) return local_[here] - local_[before];
        return {};
    }

    const SampledChart& chart_;
    std::span<const Vec3d> local_;
    std::vector<Copies> copies_;
};

}  // namespace

model::Layer make_deformation(const SampledChart& chart, std::span<const Vec3d> local) {
    model::Layer layer = empty_layer(model::layers::kDeformation, model::ElementType::kF32, {chart.m, chart.n, 4});
    const auto out = values<float>(layer);
    const Tangents tangents(chart, local);
    const auto& alpha = chart.disk->mesh.corner_colours;
    const bool painted = std::any_of(alpha.begin(), alpha.end(), [](model::Rgba8 c) { return c.a != 255; });
    for (std::uint32_t i = 0; i < chart.m; ++i)
        for (std::uint32_t j = 0; j < chart.n; ++j) {
            const std::size_t s = std::size_t{i} * chart.n + j;
            if (!chart.on_surface(s)) continue;
            const Vec3d Xi = tangents.along_i(i, j), Xj = tangents.along_j(i, j);
            out[4 * s] = static_cast<float>(dot(Xi, Xi));
            out[4 * s + 1] = static_cast<float>(dot(Xi, Xj));
            out[4 * s + 2] = static_cast<float>(dot(Xj, Xj));
            double stiffness = 1;
            const SurfaceSample& at = chart.samples[chart.representative[s]];
            if (painted && at.face != kNone) {
                stiffness = 0;
                for (int k = 0; k < 3; ++k) stiffness += at.b[k] * alpha[3 * at.face + k].a / 255.0;
            }
            out[4 * s + 3] = static_cast<float>(stiffness);
        }
    return layer;
}

}  // namespace dgm::bake
