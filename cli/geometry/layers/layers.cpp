// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/layers.cpp
// The tables beside the layers, and all of them in file order.
#include "geometry/layers/layers.h"

#include <algorithm>

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
        if (chart.representative[s] != s) pairs.push_back(chart.representative[s]), pairs.push_back(s);
    if (!pairs.empty()) {
        // Ordered by class, then by copy.
        std::vector<std::pair<std::uint32_t, std::uint32_t>> sorted;
        for (std::size_t k = 0; k < pairs.size(); k += 2) sorted.emplace_back(pairs[k], pairs[k + 1]);
        std::sort(sorted.begin(), sorted.end());
        model::Layer& seams = out.emplace_back(empty_layer("seams", model::ElementType::kU32, {sorted.size(), 2}));
        const auto to = values<std::uint32_t>(seams);
        for (std::size_t k = 0; k < sorted.size(); ++k) to[2 * k] = sorted[k].first, to[2 * k + 1] = sorted[k].second;
        seams.required = true;
    }
    model::Layer& diagonals = out.emplace_back(empty_layer("diagonals", model::ElementType::kU8, {chart.m - 1, chart.n - 1}));
    std::copy(chart.diagonals.begin(), chart.diagonals.end(), values<std::uint8_t>(diagonals).begin());
    if (chart.domain == layout::Domain::kSquare) return out;
    model::Layer& mask = out.emplace_back(empty_layer("mask", model::ElementType::kU8, {chart.m, chart.n}));
    std::copy(chart.mask.begin(), chart.mask.end(), values<std::uint8_t>(mask).begin());
    model::Layer& uv = out.emplace_back(empty_layer("border_uv", model::ElementType::kF32, {chart.border_uv.size(), 2}));
    for (std::size_t b = 0; b < chart.border_uv.size(); ++b) {
        values<float>(uv)[2 * b] = static_cast<float>(chart.border_uv[b].x);
        values<float>(uv)[2 * b + 1] = static_cast<float>(chart.border_uv[b].y);
    }
    model::Layer& faces = out.emplace_back(empty_layer("border_faces", model::ElementType::kU32, {chart.strip.size(), 3}));
    for (std::size_t f = 0; f < chart.strip.size(); ++f)
        for (int k = 0; k < 3; ++k) values<std::uint32_t>(faces)[3 * f + k] = chart.strip[f][k];
    for (const char* name : {"mask", "border_uv", "border_faces"})
        std::find_if(out.begin(), out.end(), [&](const model::Layer& l) { return l.name == name; })->required = true;
    return out;
}

bool wants(std::span<const std::string> asked, std::string_view name) {
    return asked.empty() || std::find(asked.begin(), asked.end(), name) != asked.end();
}

ChartLayers make_layers(const LayerInput& in, std::span<const std::string> asked) {
    const SampledChart& sampled = in.chart;
    ChartLayers out;
    model::Chart& chart = out.chart;
    chart.rows = sampled.m, chart.cols = sampled.n;
    chart.domain = sampled.domain;
    chart.method = sampled.method;
    chart.offset = in.stored.offset;
    chart.scale = in.stored.scale;
    StoredPositions positions = store_positions(in);
    StoredNormals normals = store_normals(in);
    out.worst_quantisation = positions.worst_quantisation;
    for (int k = 0; k < 3; ++k) chart.bbox[k] = INFINITY, chart.bbox[k + 3] = -INFINITY;
    for (std::size_t s = 0; s < positions.local.size(); ++s) {
        if (!sampled.on_surface(s)) continue;
        for (int k = 0; k < 3; ++k) {
            const double x = in.stored.offset[k] + positions.local[s][k];
            chart.bbox[k] = std::min(chart.bbox[k], x), chart.bbox[k + 3] = std::max(chart.bbox[k + 3], x);
        }
    }
    std::vector<model::Layer>& layers = chart.layers;
    layers.push_back(std::move(positions.geometry));
    layers.back().required = true;
    if (wants(asked, "normal")) layers.push_back(std::move(normals.normal));
    if (wants(asked, "texture"))
        if (auto texture = make_texture(in)) layers.push_back(std::move(*texture));
    if (wants(asked, "bump")) layers.push_back(make_bump(in, positions, normals));
    if (wants(asked, "collision")) {
        layers.push_back(make_collision(sampled, positions.local));
        layers.push_back(make_cover(sampled, positions.local));
    }
    if (wants(asked, "deformation")) layers.push_back(make_deformation(sampled, positions.local));
    if (wants(asked, "contact")) layers.push_back(make_contact(sampled, positions.local));
    for (model::Layer& table : make_tables(sampled)) layers.push_back(std::move(table));
    if (positions.border_geometry) {
        layers.push_back(std::move(*positions.border_geometry));
        layers.back().required = true;
    }
    if (normals.border_normal && wants(asked, "normal")) layers.push_back(std::move(*normals.border_normal));
    return out;
}

}  // namespace dgm::bake
