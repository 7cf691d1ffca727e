// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/viewer_data.cpp
#include "report/viewer_data.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "render/normals.h"
#include "report/draw_mesh.h"
#include "report/html.h"
#include "report/thinned_grid.h"

namespace dgm::report {
namespace {
using model::Face;
using model::Vec3d;
using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "arrays are put into pages as they are in memory");

constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kLargestStride = 64;
constexpr std::uint32_t kGridLines = 32;

using Pair = std::array<std::uint32_t, 2>;

/// All shown charts as one list of vertices.
struct MapMesh {
    DrawMesh mesh;
    std::array<std::vector<std::uint8_t>, 3> places;  // by Quantity
    std::vector<Pair> grid, seams, borders;
};

std::size_t count_vertices(const std::vector<Face>& faces, std::size_t all) {
    std::vector<bool> used(all, false);
    for (const Face& f : faces)
        for (const std::uint32_t v : f) used[v] = true;
    return static_cast<std::size_t>(std::count(used.begin(), used.end(), true));
}

struct Thinned {
    std::uint32_t stride = 1;
    std::vector<std::vector<Face>> faces;  // of the charts that are shown
};

/// The smallest stride with which all charts fit; if none does, the charts that fit with the largest.
Thinned thinned(const ViewedCharts& map, std::size_t most) {
    for (std::uint32_t stride = 1;; stride *= 2) {
        Thinned out{stride, {}};
        std::size_t total = 0;
        for (std::size_t k = 0; k < map.charts.size(); ++k) {
            out.faces.push_back(thinned_faces(map.charts[k], map.surfaces[k], stride));
            total += count_vertices(out.faces.back(), map.surfaces[k].mesh.positions.size());
            if (total <= most) continue;
            out.faces.pop_back();
            break;
        }
        if (total <= most || stride == kLargestStride) return out;
    }
}

std::vector<Vec3d> vertex_normals(const bake::Reconstruction& surface) {
    const model::TriMesh& mesh = surface.mesh;
    constexpr double kAllSmooth = 180;
    const std::vector<Vec3d> corners =
        mesh.corner_normals.empty() ? render::smooth_corner_normals(mesh, kAllSmooth) : mesh.corner_normals;
    std::vector<Vec3d> out(mesh.positions.size(), Vec3d{0, 0, 1});
    for (std::size_t c = 0; c < corners.size(); ++c) out[mesh.faces[c / 3][c % 3]] = corners[c];
    return out;
}

/// The largest distance among the samples that a thinned vertex stands for, so that no bad spot is thinned away.
double worst_nearby(const model::Chart& chart, const std::vector<double>& distance, std::uint32_t v,
                    std::uint32_t stride) {
    const std::int64_t m = chart.rows, n = chart.cols, reach = stride / 2;
    double worst = distance[v];
    if (v >= m * n || reach == 0) return worst;
    const std::int64_t i = v / n, j = v % n;
    for (std::int64_t a = std::max<std::int64_t>(0, i - reach); a <= std::min(m - 1, i + reach); ++a)
        for (std::int64_t b = std::max<std::int64_t>(0, j - reach); b <= std::min(n - 1, j + reach); ++b) {
            const double other = distance[static_cast<std::size_t>(a * n + b)];
            if (std::abs(other) > std::abs(worst)) worst = other;
        }
    return worst;
}

std::uint8_t byte_of(double place) {
    return static_cast<std::uint8_t>(std::isnan(place) ? 0 : std::lround(255 * std::clamp(place, 0.0, 1.0)));
}

/// Borders of the full chart: thinning keeps all of them. Seams are those that another border edge meets.
void add_borders(const bake::Reconstruction& surface, const std::vector<std::uint32_t>& number, MapMesh& out) {
    std::vector<Pair> edges;
    for (const Face& f : surface.mesh.faces)
        for (std::size_t k = 0; k < 3; ++k) edges.push_back({f[k], f[(k + 1) % 3]});
    std::sort(edges.begin(), edges.end());
    const auto welded = [&](const Pair& e) {
        const auto [a, b] = std::minmax(surface.weld[e[0]], surface.weld[e[1]]);
        return Pair{a, b};
    };
    std::vector<Pair> border, keys;
    for (const Pair& e : edges)
        if (!std::binary_search(edges.begin(), edges.end(), Pair{e[1], e[0]})) {
            border.push_back(e);
            keys.push_back(welded(e));
        }
    std::sort(keys.begin(), keys.end());
    for (const Pair& e : border) {
        const auto [first, last] = std::equal_range(keys.begin(), keys.end(), welded(e));
        if (number[e[0]] == kUnused || number[e[1]] == kUnused) continue;
        (last - first > 1 ? out.seams : out.borders).push_back({number[e[0]], number[e[1]]});
    }
}

void add_grid(const model::Chart& chart, const std::vector<Face>& faces, std::uint32_t stride,
              const std::vector<std::uint32_t>& number, MapMesh& out) {
    const std::uint32_t n = chart.cols, grid = chart.rows * n;
    const auto step_of = [&](std::uint32_t samples) {
        const std::uint32_t step = std::max(1U, (samples - 1) / kGridLines);
        return (step + stride - 1) / stride * stride;
    };
    const std::uint32_t row_step = step_of(chart.rows), col_step = step_of(n);
    std::set<Pair> lines;
    for (const Face& f : faces)
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [a, b] = std::minmax(f[k], f[(k + 1) % 3]);
            if (b >= grid) continue;
            const bool row = a / n == b / n && a / n % row_step == 0, col = a % n == b % n && a % n % col_step == 0;
            if (row || col) lines.insert({number[a], number[b]});
        }
    out.grid.insert(out.grid.end(), lines.begin(), lines.end());
}

MapMesh map_mesh(const ViewedCharts& map, const Thinned& thin, const Scales& scales) {
    MapMesh out;
    for (std::size_t k = 0; k < thin.faces.size(); ++k) {
        const bake::Reconstruction& surface = map.surfaces[k];
        const SurfaceValues& values = map.values[k];
        const std::vector<Vec3d> normals = vertex_normals(surface);
        std::vector<std::uint32_t> number(surface.mesh.positions.size(), kUnused);
        const auto number_of = [&](std::uint32_t v) {
            if (number[v] != kUnused) return number[v];
            number[v] = static_cast<std::uint32_t>(out.mesh.positions.size());
            out.mesh.positions.push_back(surface.mesh.positions[v]);
            out.mesh.normals.push_back(normals[v]);
            const double distance = worst_nearby(map.charts[k], values.distance, v, thin.stride);
            out.places[0].push_back(byte_of(table_place(Quantity::kDistance, distance, scales)));
            out.places[1].push_back(byte_of(table_place(Quantity::kArea, values.area[v], scales)));
            out.places[2].push_back(byte_of(table_place(Quantity::kAngle, values.angle[v], scales)));
            return number[v];
        };
        for (const Face& f : thin.faces[k]) {
            const std::uint32_t a = number_of(f[0]), b = number_of(f[1]), c = number_of(f[2]);
            out.mesh.faces.push_back({a, b, c});
        }
        add_borders(surface, number, out);
        add_grid(map.charts[k], thin.faces[k], thin.stride, number, out);
    }
    return out;
}

struct Box {
    Vec3d low, high;
    bool empty = true;
    void add(const Vec3d& p) {
        if (!is_finite(p)) return;
        if (empty) low = high = p;
        for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]), high[k] = std::max(high[k], p[k]);
        empty = false;
    }
};

template <class List>
std::string encoded_indices(const List& list, bool wide) {
    std::vector<std::uint16_t> narrow;
    std::vector<std::uint32_t> all;
    for (const auto& entry : list)
        for (const std::uint32_t v : entry) wide ? all.push_back(v) : narrow.push_back(static_cast<std::uint16_t>(v));
    return wide ? base64_of(all) : base64_of(narrow);
}

json encoded(const DrawMesh& mesh, const Vec3d& low, double step) {
    constexpr double kMost = 65535;
    std::vector<std::uint16_t> position;
    std::vector<std::int8_t> normal;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
        for (int k = 0; k < 3; ++k) {
            const double stored = (mesh.positions[v][k] - low[k]) / step;
            position.push_back(std::isfinite(stored)
                                   ? static_cast<std::uint16_t>(std::lround(std::clamp(stored, 0.0, kMost)))
                                   : std::uint16_t{0});
            normal.push_back(static_cast<std::int8_t>(std::lround(127 * std::clamp(mesh.normals[v][k], -1.0, 1.0))));
        }
    const bool wide = mesh.positions.size() > 65536;
    return {{"position", base64_of(position)},
            {"normal", base64_of(normal)},
            {"index", encoded_indices(mesh.faces, wide)},
            {"wide", wide}};
}

std::string table(Quantity quantity) {
    std::vector<std::uint8_t> bytes;
    for (int k = 0; k < 256; ++k) {
        const model::Rgba8 colour = quantity_colour(quantity, k / 255.0);
        bytes.insert(bytes.end(), {colour.r, colour.g, colour.b});
    }
    return base64_of(bytes);
}
}  // namespace

json viewer_data(const ViewedSource& source, const ViewedCharts& map, const Scales& scales, double diagonal,
                 const render::View& view, std::size_t most_vertices) {
    const DrawMesh original = draw_mesh(source.mesh, most_vertices);
    const Thinned thin = thinned(map, most_vertices);
    const MapMesh rebuilt = map_mesh(map, thin, scales);
    Box box;
    for (const Vec3d& p : original.positions) box.add(p);
    for (const Vec3d& p : rebuilt.mesh.positions) box.add(p);
    const Vec3d size = box.high - box.low;
    const double step = std::max({size.x, size.y, size.z, std::numeric_limits<double>::min()}) / 65535;

    json out{{"view", {{"yaw", view.yaw_degrees}, {"pitch", view.pitch_degrees}}},
             {"low", {box.low.x, box.low.y, box.low.z}},
             {"size", {size.x, size.y, size.z}},
             {"step", step},
             {"stride", thin.stride},
             {"charts", thin.faces.size()},
             {"diagonal", diagonal},
             {"scales",
              {{"distance", scales.distance}, {"worst", scales.worst}, {"area", scales.area}, {"angle", scales.angle}}},
             {"tables", {{"diverging", table(Quantity::kDistance)}, {"sequential", table(Quantity::kAngle)}}}};
    out["source"] = encoded(original, box.low, step);
    out["source"]["simplified"] = original.simplified;
    std::vector<double> worst(original.positions.size(), 0);
    for (const auto& [drawn, vertex] : original.origins)
        if (const double value = source.distances[vertex]; std::abs(value) > std::abs(worst[drawn]))
            worst[drawn] = value;
    std::vector<std::uint8_t> places;
    places.reserve(worst.size());
    for (const double value : worst) places.push_back(byte_of(table_place(Quantity::kDistance, value, scales)));
    out["source"]["distance"] = base64_of(places);
    if (thin.faces.empty()) return out;
    json& target = out["map"] = encoded(rebuilt.mesh, box.low, step);
    target["distance"] = base64_of(rebuilt.places[0]);
    target["area"] = base64_of(rebuilt.places[1]);
    target["angle"] = base64_of(rebuilt.places[2]);
    const bool wide = target["wide"];
    target["grid"] = encoded_indices(rebuilt.grid, wide);
    target["seams"] = encoded_indices(rebuilt.seams, wide);
    target["borders"] = encoded_indices(rebuilt.borders, wide);
    return out;
}

}  // namespace dgm::report
