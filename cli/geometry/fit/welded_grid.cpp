// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/welded_grid.cpp
#include "geometry/fit/welded_grid.h"

#include <algorithm>

#include "geometry/metrics/turned_faces.h"

namespace dgm::bake {
namespace {

/// A half-edge keyed by its ends, lower first.
struct EdgeUse {
    std::uint64_t key;
    std::uint32_t half_edge;
};

std::vector<EdgeUse> sorted_edge_uses(const std::vector<Face>& faces) {
    const auto lower = [&](std::uint32_t f, std::uint32_t k) { return std::min(faces[f][k], faces[f][(k + 1) % 3]); };
    std::vector<std::uint32_t> first;  // by the lower end, then each of those few
    for (std::uint32_t f = 0; f < faces.size(); ++f)
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (const std::size_t size = std::size_t{lower(f, k)} + 2; first.size() < size) first.resize(size, 0);
            ++first[lower(f, k) + 1];
        }
    for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
    std::vector<EdgeUse> uses(3 * faces.size());
    std::vector<std::uint32_t> next = first;
    for (std::uint32_t f = 0; f < faces.size(); ++f)
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint64_t a = faces[f][k], b = faces[f][(k + 1) % 3];
            uses[next[lower(f, k)]++] = {std::min(a, b) << 32 | std::max(a, b), 3 * f + k};
        }
    for (std::size_t v = 1; v < first.size(); ++v)
        std::sort(uses.begin() + first[v - 1], uses.begin() + first[v], [](const EdgeUse& a, const EdgeUse& b) {
            return a.key != b.key ? a.key < b.key : a.half_edge < b.half_edge;
        });
    return uses;
}

}  // namespace

WeldedGrid::WeldedGrid(const SampledChart& chart) {
    const std::size_t count = chart.positions.size();
    class_of.assign(count, kNone);
    for (std::uint32_t s = 0; s < count; ++s) {
        if (!chart.on_surface(s)) continue;
        const std::uint32_t rep = chart.representative[s];
        if (class_of[rep] == kNone) {
            class_of[rep] = static_cast<std::uint32_t>(sample_of.size());
            sample_of.push_back(rep);
            surface.positions.push_back(chart.positions[rep]);
        }
        class_of[s] = class_of[rep];
    }
    if (!chart.reversed.empty()) reversed.assign(sample_of.size(), 0);
    for (std::uint32_t s = 0; s < chart.reversed.size(); ++s)
        if (chart.reversed[s]) reversed[class_of[s]] = 1;
    face_of_quad.assign(std::size_t{chart.m - 1} * (chart.n - 1), kNone);
    std::uint32_t next = 0;
    for (std::uint32_t i = 0; i + 1 < chart.m; ++i)
        for (std::uint32_t j = 0; j + 1 < chart.n; ++j)
            if (chart.has_quad(i, j)) {
                face_of_quad[std::size_t{i} * (chart.n - 1) + j] = next;
                next += 2;
            }
    link(chart);
}

void WeldedGrid::link(const SampledChart& chart) {
    surface.faces = chart.faces();
    for (Face& f : surface.faces)
        for (std::uint32_t& s : f) s = class_of[s];
    const std::vector<EdgeUse> uses = sorted_edge_uses(surface.faces);
    edges.clear();
    edge_of.resize(surface.faces.size());
    surface.neighbours.assign(surface.faces.size(), {kNone, kNone, kNone});
    on_border.assign(sample_of.size(), 0);
    for (std::size_t k = 0; k < uses.size();) {
        std::size_t end = k + 1;
        while (end < uses.size() && uses[end].key == uses[k].key) ++end;
        const auto id = static_cast<std::uint32_t>(edges.size());
        edges.emplace_back(static_cast<std::uint32_t>(uses[k].key >> 32), static_cast<std::uint32_t>(uses[k].key));
        for (std::size_t e = k; e < end; ++e) edge_of[uses[e].half_edge / 3][uses[e].half_edge % 3] = id;
        if (end - k == 2) {
            const std::uint32_t a = uses[k].half_edge, b = uses[k + 1].half_edge;
            surface.neighbours[a / 3][a % 3] = b / 3;
            surface.neighbours[b / 3][b % 3] = a / 3;
        } else if (end - k == 1) {
            on_border[edges.back().first] = on_border[edges.back().second] = 1;
        }
        k = end;
    }
    surface.update_normals();
    surface.either_side = faces_beside_reversed(surface.faces, reversed);
}

std::uint32_t WeldedGrid::face_at(const SampledChart& chart, const Vec2d& uv) const {
    const auto cell = [](double x, std::uint32_t samples) {
        return static_cast<std::size_t>(std::clamp(x * (samples - 1), 0.0, static_cast<double>(samples - 2)));
    };
    return face_of_quad[cell(uv.x, chart.m) * (chart.n - 1) + cell(uv.y, chart.n)];
}

std::uint32_t WeldedGrid::face_at(const SampledChart& chart, const SurfaceSample& at) const {
    const Face& v = chart.disk->mesh.faces[at.face];
    return face_at(chart, chart.uv[v[0]] * at.b[0] + chart.uv[v[1]] * at.b[1] + chart.uv[v[2]] * at.b[2]);
}

void WeldedGrid::write_positions(SampledChart& chart) const {
    for (std::size_t s = 0; s < chart.positions.size(); ++s)
        if (class_of[s] != kNone) chart.positions[s] = surface.positions[class_of[s]];
}

WeldedGrid::Rings WeldedGrid::rings() const {
    const std::size_t count = surface.positions.size();
    Rings out{std::vector<std::uint32_t>(count + 1, 0), std::vector<std::uint32_t>(3 * surface.faces.size())};
    for (const Face& f : surface.faces)
        for (const std::uint32_t c : f) ++out.first[c + 1];
    for (std::size_t c = 0; c < count; ++c) out.first[c + 1] += out.first[c];
    std::vector<std::uint32_t> next(out.first.begin(), out.first.end() - 1);
    for (std::uint32_t f = 0; f < surface.faces.size(); ++f)
        for (const std::uint32_t c : surface.faces[f]) out.faces[next[c]++] = f;
    return out;
}

}  // namespace dgm::bake
