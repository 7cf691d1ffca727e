// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/compared_map.cpp
#include "export/compared_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "geometry/metrics/reconstruction.h"
#include "geometry/spatial/closest_point.h"
#include "model/element.h"
#include "model/layer_names.h"
#include "render/chart_surface.h"
#include "render/draw_mesh.h"

namespace dgm::exporter {
namespace {
using render::Quantity;

std::uint8_t code_of(double place) {
    return static_cast<std::uint8_t>(std::isnan(place) ? 0 : std::lround(255 * std::clamp(place, 0.0, 1.0)));
}

page::PagedValues coded(std::size_t chart, const char* name, Quantity quantity, const std::vector<double>& values,
                        const render::Scales& scales) {
    const double end = quantity == Quantity::kDistance ? scales.distance
                       : quantity == Quantity::kArea   ? scales.area
                                                       : scales.angle;
    const bool diverging = quantity != Quantity::kAngle;
    page::PagedValues out{chart, name, diverging ? -end : 0, end, diverging, {}};
    for (const double value : values) out.codes.push_back(code_of(render::table_place(quantity, value, scales)));
    return out;
}
}  // namespace

void add_comparison(const Compared& compared, page::PagedMap& map) {
    for (std::size_t k = 0; k < compared.values.size(); ++k) {
        const render::SurfaceValues& values = compared.values[k];
        map.values.push_back(coded(k, kDistanceName, Quantity::kDistance, values.distance, compared.scales));
        map.values.push_back(coded(k, kAreaName, Quantity::kArea, values.area, compared.scales));
        map.values.push_back(coded(k, kAngleName, Quantity::kAngle, values.angle, compared.scales));
    }
    const render::DrawMesh drawn = render::draw_mesh(compared.source, kMostSourceVertices);
    // The largest distance among those that a drawn vertex stands for, so that no bad spot is simplified away.
    std::vector<double> worst(drawn.positions.size(), 0);
    for (const auto& [vertex, origin] : drawn.origins)
        if (const double value = compared.distances[origin]; std::abs(value) > std::abs(worst[vertex]))
            worst[vertex] = value;
    map.source = page::PagedSource{drawn.positions, drawn.faces, kDistanceName, {}};
    for (const double value : worst)
        map.source->codes.push_back(code_of(render::table_place(Quantity::kDistance, value, compared.scales)));
}

void compare_with(const model::TriMesh& source, page::PagedMap& map) {
    const bake::ClosestPointIndex index(source.positions, source.faces);
    std::vector<render::SurfaceValues> values;
    for (const model::Chart& chart : map.maps->charts)
        values.push_back(render::surface_values(chart, bake::reconstruct(chart), index));
    const std::vector<double> distances =
        render::source_distances(source, render::chart_surface(map.maps->charts).mesh);
    add_comparison({source, distances, values, render::scales_of(values, distances)}, map);
}

void add_bump(page::PagedMap& map) {
    for (std::size_t k = 0; k < map.maps->charts.size(); ++k) {
        const model::Chart& chart = map.maps->charts[k];
        const model::Layer* bump = chart.find(model::layers::kBump);
        if (bump == nullptr || bump->type != model::ElementType::kF16 || bump->shape.size() != 2 ||
            bump->shape[0] * bump->shape[1] == 0)
            continue;
        const auto nearest = [](std::uint32_t s, std::uint32_t samples, std::uint64_t texels) {
            const std::uint64_t last = std::max(1U, samples - 1);
            return (2 * s * (texels - 1) + last) / (2 * last);
        };
        std::vector<double> heights;
        for (std::uint32_t i = 0; i < chart.rows; ++i)
            for (std::uint32_t j = 0; j < chart.cols; ++j)
                heights.push_back(model::element_value(*bump, nearest(i, chart.rows, bump->shape[0]) * bump->shape[1] +
                                                                  nearest(j, chart.cols, bump->shape[1])));
        double end = 0;
        for (const double h : heights)
            if (std::isfinite(h)) end = std::max(end, std::abs(h));
        if (!(end > 0)) continue;
        page::PagedValues out{k, "bump: height beyond the grid", -end, end, true, {}};
        for (const double h : heights) out.codes.push_back(code_of(0.5 + 0.5 * h / end));
        map.values.push_back(std::move(out));
    }
}

std::string measured_errors(const nlohmann::json& report) {
    const nlohmann::json::json_pointer at("/error");
    if (!report.is_object() || !report.contains(at) || !report.at(at).is_object()) return {};
    const nlohmann::json& error = report.at(at);
    const auto number = [&](const char* key) {
        return error.contains(key) && error.at(key).is_number() ? error.at(key).get<double>() : NAN;
    };
    const double rms = number("rms"), largest = number("hausdorff"), diagonal = number("diagonal");
    if (!std::isfinite(rms + largest) || !(diagonal > 0)) return {};
    return fmt::format("rms error {:.3g} ({:.2g} % of the diagonal), largest {:.3g} ({:.2g} %)", rms,
                       100 * rms / diagonal, largest, 100 * largest / diagonal);
}

}  // namespace dgm::exporter
