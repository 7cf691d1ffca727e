// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/chart_surface.cpp
#include "render/chart_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

#include <dgm/grid.h>

#include "geometry/metrics/reconstruction.h"
#include "model/codes.h"
#include "render/layer_values.h"

namespace dgm::render {
namespace {
using model::Chart;
using model::ElementType;
using model::Layer;
using model::Vec2d;
using Edge = ChartSurface::Edge;

constexpr std::uint32_t kGridLines = 32;

/// reconstruct() gives (v, u), 0..1 from the first sample to the last.
Vec2d texel_centre(Vec2d vu, std::uint32_t across, std::uint32_t down) {
    return {(vu.x * (across - 1.0) + 0.5) / across, 1 - (vu.y * (down - 1.0) + 0.5) / down};
}

/// Edges of the faces that have no face on their other side, split into those that coincide with another one after
/// welding (seams) and the rest (true borders).
void add_border_edges(const bake::Reconstruction& chart, std::uint32_t base, ChartSurface& out) {
    struct HalfEdge {
        std::uint64_t key;  // lower vertex, higher vertex
        Edge edge;
    };
    const auto key_of = [](std::uint32_t a, std::uint32_t b) {
        return (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
    };
    const auto for_runs = [](std::vector<HalfEdge>& edges, auto visit) {
        std::sort(edges.begin(), edges.end(), [](const HalfEdge& x, const HalfEdge& y) {
            return std::tie(x.key, x.edge.a, x.edge.b) < std::tie(y.key, y.edge.a, y.edge.b);
        });
        for (std::size_t first = 0, last = 0; first < edges.size(); first = last) {
            while (last < edges.size() && edges[last].key == edges[first].key) ++last;
            visit(std::span(edges).subspan(first, last - first));
        }
    };
    std::vector<HalfEdge> all, border;
    for (const model::Face& face : chart.mesh.faces)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = face[k], b = face[(k + 1) % 3];
            all.push_back({key_of(a, b), {a, b}});
        }
    for_runs(all, [&](std::span<HalfEdge> run) {
        if (run.size() != 1) return;
        const Edge e = run[0].edge;
        border.push_back({key_of(chart.weld[e.a], chart.weld[e.b]), e});
    });
    for_runs(border, [&](std::span<HalfEdge> run) {
        for (const HalfEdge& h : run)
            (run.size() > 1 ? out.seams : out.borders).push_back({base + h.edge.a, base + h.edge.b});
    });
}

void add_grid_lines(const Chart& chart, const bake::Reconstruction& rebuilt, std::uint32_t base, ChartSurface& out) {
    const std::uint32_t m = chart.rows, n = chart.cols;
    std::vector<bool> used(std::size_t{m} * n, false);
    for (const model::Face& face : rebuilt.mesh.faces)
        for (const std::uint32_t v : face)
            if (v < used.size()) used[v] = true;
    const auto add = [&](std::size_t a, std::size_t b) {
        if (used[a] && used[b])
            out.grid.push_back({base + static_cast<std::uint32_t>(a), base + static_cast<std::uint32_t>(b)});
    };
    const auto step_of = [](std::uint32_t samples) { return std::max(1u, (samples - 1) / kGridLines); };
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            if (i % step_of(m) == 0 && j + 1 < n) add(sample_index(i, j, n), sample_index(i, j + 1, n));
            if (j % step_of(n) == 0 && i + 1 < m) add(sample_index(i, j, n), sample_index(i + 1, j, n));
        }
}
}  // namespace

formats::Image texture_picture(const Chart& chart) {
    const Layer* layer = chart.find("texture");
    if (layer == nullptr) return {};
    const Plane plane = read_plane(*layer, {ElementType::kU8}, 4);
    formats::Image image{plane.cols, plane.rows, std::vector<model::Rgba8>(std::size_t{plane.rows} * plane.cols)};
    for (std::size_t s = 0; s < image.pixels.size(); ++s) {
        const auto channel = [&](std::size_t c) { return static_cast<std::uint8_t>(plane.values[4 * s + c]); };
        image.pixels[s] = {channel(0), channel(1), channel(2), channel(3)};
    }
    return image;
}

ChartSurface chart_surface(std::span<const Chart> charts) {
    ChartSurface out;
    const bool has_normals = std::all_of(charts.begin(), charts.end(), [](const Chart& c) { return c.find("normal"); });
    for (std::size_t k = 0; k < charts.size(); ++k) {
        const Chart& chart = charts[k];
        bake::Reconstruction rebuilt = bake::reconstruct(chart);
        model::TriMesh& mesh = rebuilt.mesh;
        if (out.mesh.positions.size() + mesh.positions.size() > std::numeric_limits<std::uint32_t>::max())
            throw model::Error(model::codes::kTooLarge, "the charts together have more than 2^32 vertices");
        const auto base = static_cast<std::uint32_t>(out.mesh.positions.size());
        out.textures.push_back(texture_picture(chart));
        const formats::Image& texture = out.textures.back();
        const std::uint32_t across = texture.pixels.empty() ? chart.cols : texture.width;
        const std::uint32_t down = texture.pixels.empty() ? chart.rows : texture.height;

        out.mesh.positions.insert(out.mesh.positions.end(), mesh.positions.begin(), mesh.positions.end());
        for (model::Face face : mesh.faces) {
            for (std::uint32_t& v : face) v += base;
            out.mesh.faces.push_back(face);
            out.mesh.face_materials.push_back(static_cast<std::uint32_t>(k));
        }
        for (const Vec2d vu : mesh.corner_uvs) out.mesh.corner_uvs.push_back(texel_centre(vu, across, down));
        if (has_normals)
            out.mesh.corner_normals.insert(out.mesh.corner_normals.end(), mesh.corner_normals.begin(),
                                           mesh.corner_normals.end());
        model::Material material;
        material.name = "chart" + std::to_string(k);
        material.diffuse = Surface{}.plain;
        out.mesh.materials.push_back(material);
        out.seam_gap = std::max(out.seam_gap, rebuilt.seam_gap);
        add_border_edges(rebuilt, base, out);
        add_grid_lines(chart, rebuilt, base, out);
    }
    return out;
}

void add_segments(Surface& surface, std::span<const Edge> edges, model::Rgba8 colour, double radius) {
    for (const Edge& e : edges) {
        const model::Vec3d &a = surface.mesh->positions[e.a], &b = surface.mesh->positions[e.b];
        if (is_finite(a) && is_finite(b)) surface.segments.push_back({a, b, colour, radius});
    }
}

}  // namespace dgm::render
