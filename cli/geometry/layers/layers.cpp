// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/layers.cpp
// The tables beside the layers, and all of them in file order.
#include "geometry/layers/layers.h"

#include <algorithm>
#include <cmath>

#include "geometry/layers/fit_layers.h"
#include "geometry/metrics/bump_normals.h"
#include "model/layer_names.h"

namespace dgm::bake {

model::Layer empty_layer(std::string name, model::ElementType type, std::vector<std::uint64_t> shape) {
    model::Layer layer;
    layer.name = std::move(name);
    layer.type = type;
    std::uint64_t count = layout::element_size(type);
    for (std::uint64_t n : shape) count *= n;
    layer.shape = std::move(shape);
    layer.bytes.resize(count);
    return layer;
}

std::vector<model::Layer> make_tables(const SampledChart& chart) {
    std::vector<model::Layer> out;
    std::vector<std::uint32_t> pairs;
    for (std::uint32_t s = 0; s < chart.representative.size(); ++s)
        if (chart.representative[s] != s) {
            pairs.push_back(chart.representative[s]);
            pairs.push_back(s);
        }
    if (!pairs.empty()) {
        // Ordered by class, then by copy.
        std::vector<std::pair<std::uint32_t, std::uint32_t>> sorted;
        for (std::size_t k = 0; k < pairs.size(); k += 2) sorted.emplace_back(pairs[k], pairs[k + 1]);
        std::sort(sorted.begin(), sorted.end());
        model::Layer& seams =
            out.emplace_back(empty_layer(model::layers::kSeams, model::ElementType::kU32, {sorted.size(), 2}));
        const auto to = values<std::uint32_t>(seams);
        for (std::size_t k = 0; k < sorted.size(); ++k) {
            to[2 * k] = sorted[k].first;
            to[2 * k + 1] = sorted[k].second;
        }
        seams.required = true;
        if (!chart.reversed.empty()) {
            // Required: a reader that does not know it would weld opposite normals.
            model::Layer& reversed =
                out.emplace_back(empty_layer(model::layers::kReversed, model::ElementType::kU8, {sorted.size()}));
            for (std::size_t k = 0; k < sorted.size(); ++k)
                values<std::uint8_t>(reversed)[k] = chart.reversed[sorted[k].second];
            reversed.required = true;
        }
    }
    model::Layer& diagonals =
        out.emplace_back(empty_layer(model::layers::kDiagonals, model::ElementType::kU8, {chart.m - 1, chart.n - 1}));
    std::copy(chart.diagonals.begin(), chart.diagonals.end(), values<std::uint8_t>(diagonals).begin());
    if (chart.domain == layout::Domain::kSquare) return out;
    model::Layer& mask =
        out.emplace_back(empty_layer(model::layers::kMask, model::ElementType::kU8, {chart.m, chart.n}));
    std::copy(chart.mask.begin(), chart.mask.end(), values<std::uint8_t>(mask).begin());
    model::Layer& uv =
        out.emplace_back(empty_layer(model::layers::kBorderUv, model::ElementType::kF32, {chart.border_uv.size(), 2}));
    for (std::size_t b = 0; b < chart.border_uv.size(); ++b) {
        values<float>(uv)[2 * b] = static_cast<float>(chart.border_uv[b].x);
        values<float>(uv)[2 * b + 1] = static_cast<float>(chart.border_uv[b].y);
    }
    model::Layer& faces =
        out.emplace_back(empty_layer(model::layers::kBorderFaces, model::ElementType::kU32, {chart.strip.size(), 3}));
    for (std::size_t f = 0; f < chart.strip.size(); ++f)
        for (int k = 0; k < 3; ++k) values<std::uint32_t>(faces)[3 * f + k] = chart.strip[f][k];
    for (const char* name : {model::layers::kMask, model::layers::kBorderUv, model::layers::kBorderFaces})
        std::find_if(out.begin(), out.end(), [&](const model::Layer& l) { return l.name == name; })->required = true;
    return out;
}

bool wants(std::span<const std::string> asked, std::string_view name) {
    return asked.empty() || std::find(asked.begin(), asked.end(), name) != asked.end();
}

namespace {
/// How many source points the layers asked for are fitted to: five a sample, as the positions are; two a texel where
/// there are more of those.
std::size_t match_count(const LayerInput& in, std::span<const std::string> asked) {
    constexpr std::size_t kMost = std::size_t{1} << 21;  // 200 MB
    std::size_t count = 0;
    if (wants(asked, model::layers::kNormal) || wants(asked, model::layers::kBump)) count = 5 * in.chart.grid_count();
    if (wants(asked, model::layers::kBump) && in.bump_size)
        count = std::max(count, 2 * std::size_t{in.bump_size->first} * in.bump_size->second);
    if (wants(asked, model::layers::kTexture) && has_texture(in)) {
        const auto [rows, cols] = texture_shape(in);
        count = std::max(count, 2 * std::size_t{rows} * cols);
    }
    return std::min(count, kMost);
}

/// Attribute `shading` of the bump layer (bump_normals.h): with the source's normal N, stored s and fine f, the w that
/// makes the sum of |(1 - w) s + w f - N|^2 least.
void weigh_bump(const LayerInput& in, const StoredPositions& positions, std::vector<MatchedPoint> points,
                model::Chart& chart) {
    constexpr std::size_t kEnough = 40'000;
    const Reconstruction surface = reconstruct(chart);
    const std::optional<BumpNormals> bump = BumpNormals::of(chart, surface);
    if (!bump) return;
    if (points.empty()) points = match_source(in, positions, kEnough);
    double along = 0, square = 0;
    const std::size_t stride = std::max<std::size_t>(1, points.size() / kEnough);  // one number: every so many-th do
    for (std::size_t k = 0; k < points.size(); k += stride) {
        const MatchedPoint& p = points[k];
        const auto [stored, fine] = bump->both(p.face, {p.b[0], p.b[1], p.b[2]});
        const Vec3d truth = source_normal(in.chart.disk->mesh, p.at);
        if (fine == Vec3d{} || truth == Vec3d{}) continue;
        along += dot(fine - stored, truth - stored);
        square += dot(fine - stored, fine - stored);
    }
    const double weight = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0.0;
    chart.find(model::layers::kBump)->attributes["shading"] = std::vector<double>{weight};
}
}  // namespace

ChartLayers make_layers(const LayerInput& in, std::span<const std::string> asked, const model::Progress& progress) {
    // Rough shares of the time that all layers take.
    const auto tell = [&](double share) { progress.update("layers", share); };
    const SampledChart& sampled = in.chart;
    ChartLayers out;
    model::Chart& chart = out.chart;
    chart.rows = sampled.m;
    chart.cols = sampled.n;
    chart.domain = sampled.domain;
    chart.method = sampled.method;
    chart.offset = in.stored.offset;
    chart.scale = in.stored.scale;
    StoredPositions positions = store_positions(in);
    StoredNormals normals = store_normals(in);
    std::vector<MatchedPoint> points =
        in.fitted ? match_source(in, positions, match_count(in, asked)) : std::vector<MatchedPoint>{};
    tell(0.4);
    if (!points.empty()) fit_normals(in, points, normals);
    tell(0.5);
    out.worst_quantisation = positions.worst_quantisation;
    for (int k = 0; k < 3; ++k) {
        chart.bbox[k] = INFINITY;
        chart.bbox[k + 3] = -INFINITY;
    }
    for (std::size_t s = 0; s < positions.local.size(); ++s) {
        if (!sampled.on_surface(s)) continue;
        for (int k = 0; k < 3; ++k) {
            const double x = in.stored.offset[k] + positions.local[s][k];
            chart.bbox[k] = std::min(chart.bbox[k], x);
            chart.bbox[k + 3] = std::max(chart.bbox[k + 3], x);
        }
    }
    std::vector<model::Layer>& layers = chart.layers;
    layers.push_back(std::move(positions.geometry));
    layers.back().required = true;
    if (wants(asked, model::layers::kNormal)) layers.push_back(std::move(normals.normal));
    if (wants(asked, model::layers::kTexture))
        if (auto texture = make_texture(in, points)) layers.push_back(std::move(*texture));
    tell(0.6);
    if (wants(asked, model::layers::kBump)) layers.push_back(make_bump(in, positions, normals, points));
    tell(0.8);
    if (wants(asked, model::layers::kCollision)) {
        layers.push_back(make_collision(sampled, positions.local));
        layers.push_back(make_cover(sampled, positions.local));
    }
    if (wants(asked, model::layers::kDeformation)) layers.push_back(make_deformation(sampled, positions.local));
    if (wants(asked, model::layers::kContact)) layers.push_back(make_contact(sampled, positions.local));
    for (model::Layer& table : make_tables(sampled)) layers.push_back(std::move(table));
    if (positions.border_geometry) {
        layers.push_back(std::move(*positions.border_geometry));
        layers.back().required = true;
    }
    if (normals.border_normal && wants(asked, model::layers::kNormal))
        layers.push_back(std::move(*normals.border_normal));
    if (wants(asked, model::layers::kBump) && wants(asked, model::layers::kNormal))
        weigh_bump(in, positions, std::move(points), chart);
    return out;
}

}  // namespace dgm::bake
