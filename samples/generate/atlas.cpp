// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/atlas.cpp
#include "atlas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace dgm::samples {
namespace {
using model::Vec2d;
using model::Vec3d;

constexpr double kGutter = 3;            // texels painted beyond a chart's border
constexpr std::size_t kSmallChart = 40;  // triangles; smaller charts join a neighbour where projection allows
constexpr double kLeastFacing = 0.2;     // cosine below which a face would be squeezed too much by a projection

using Neighbours = std::vector<std::array<std::size_t, 3>>;

Neighbours face_neighbours(const PolyMesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> owner;
    const auto corner = [&mesh](std::size_t f, std::size_t k) { return mesh.polygons[f].vertex[k % 3]; };
    for (std::size_t f = 0; f < mesh.polygons.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k) owner[{corner(f, k), corner(f, k + 1)}] = f;
    Neighbours out(mesh.polygons.size());
    for (std::size_t f = 0; f < mesh.polygons.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k) out[f][k] = owner.at({corner(f, k + 1), corner(f, k)});
    return out;
}

/// Label 2*axis + (0: towards +, 1: towards -).
double facing(const Vec3d& normal, int label) {
    return normal[label / 2] * (label % 2 == 0 ? 1 : -1);
}

std::vector<int> components(const std::vector<int>& label, const Neighbours& next, int& count) {
    std::vector<int> id(label.size(), -1);
    count = 0;
    for (std::size_t seed = 0; seed < label.size(); ++seed) {
        if (id[seed] >= 0) continue;
        std::vector<std::size_t> stack{seed};
        id[seed] = count;
        while (!stack.empty()) {
            const std::size_t f = stack.back();
            stack.pop_back();
            for (const std::size_t g : next[f])
                if (id[g] < 0 && label[g] == label[f]) {
                    id[g] = count;
                    stack.push_back(g);
                }
        }
        ++count;
    }
    return id;
}

// A face between two of one other label takes that label: straighter chart borders.
void straighten(std::vector<int>& label, const std::vector<Vec3d>& normal, const Neighbours& next) {
    for (int round = 0; round < 8; ++round)
        for (std::size_t f = 0; f < label.size(); ++f)
            for (std::size_t k = 0; k < 3; ++k) {
                const int other = label[next[f][k]];
                if (other != label[f] && other == label[next[f][(k + 1) % 3]] &&
                    facing(normal[f], other) > kLeastFacing)
                    label[f] = other;
            }
}

// Gives faces on the rim of small charts to the neighbour they face best, until the chart is gone or cannot shrink.
void absorb_small_charts(std::vector<int>& label, const std::vector<Vec3d>& normal, const Neighbours& next) {
    for (int round = 0; round < 12; ++round) {
        int count = 0;
        const std::vector<int> id = components(label, next, count);
        std::vector<std::size_t> size(static_cast<std::size_t>(count));
        for (const int c : id) ++size[static_cast<std::size_t>(c)];
        for (std::size_t f = 0; f < label.size(); ++f) {
            if (size[static_cast<std::size_t>(id[f])] >= kSmallChart) continue;
            int best = -1;
            for (const std::size_t g : next[f])
                if (id[g] != id[f] && facing(normal[f], label[g]) > kLeastFacing &&
                    (best < 0 || facing(normal[f], label[g]) > facing(normal[f], best)))
                    best = label[g];
            if (best >= 0) label[f] = best;
        }
    }
}

Vec2d along(const Vec3d& p, int label) {
    const Vec2d q = label / 2 == 0 ? Vec2d{p.y, p.z} : label / 2 == 1 ? Vec2d{-p.x, p.z} : Vec2d{p.x, p.y};
    return label % 2 == 0 ? q : Vec2d{-q.x, q.y};
}

struct Chart {
    int label = 0;
    Vec2d low{1e30, 1e30}, high{-1e30, -1e30};
    Vec2d origin;  // texels
};

// Shelves from tall to low; false if the charts do not fit at `scale` texels a centimetre.
bool pack(std::vector<Chart>& charts, double scale, int size) {
    std::vector<std::size_t> order(charts.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return charts[a].high.y - charts[a].low.y > charts[b].high.y - charts[b].low.y;
    });
    const double gap = 2 * kGutter + 2;
    double x = gap, y = gap, shelf = 0;
    for (const std::size_t c : order) {
        const Vec2d extent = (charts[c].high - charts[c].low) * scale;
        if (x + extent.x + gap > size) {
            x = gap;
            y += shelf + gap;
            shelf = 0;
        }
        if (x + extent.x + gap > size || y + extent.y + gap > size) return false;
        charts[c].origin = {x, y};
        x += extent.x + gap;
        shelf = std::max(shelf, extent.y);
    }
    return true;
}
}  // namespace

void project_to_atlas(PolyMesh& mesh, int size) {
    const Neighbours next = face_neighbours(mesh);
    const std::vector<Vec3d> smooth = corner_normals(mesh);
    std::vector<Vec3d> normal(mesh.polygons.size());
    std::vector<int> label(mesh.polygons.size());
    for (std::size_t f = 0; f < label.size(); ++f) {
        const auto& v = mesh.polygons[f].vertex;
        normal[f] =
            normalized(cross(mesh.positions[v[1]] - mesh.positions[v[0]], mesh.positions[v[2]] - mesh.positions[v[0]]));
        const Vec3d trend = normalized(smooth[4 * f] + smooth[4 * f + 1] + smooth[4 * f + 2]) + normal[f] * 0.5;
        for (int l = 1; l < 6; ++l)
            if (facing(trend, l) > facing(trend, label[f])) label[f] = l;
    }
    straighten(label, normal, next);
    absorb_small_charts(label, normal, next);

    int count = 0;
    const std::vector<int> id = components(label, next, count);
    std::vector<Chart> charts(static_cast<std::size_t>(count));
    for (std::size_t f = 0; f < label.size(); ++f) {
        Chart& c = charts[static_cast<std::size_t>(id[f])];
        c.label = label[f];
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec2d q = along(mesh.positions[mesh.polygons[f].vertex[k]], c.label);
            c.low = {std::min(c.low.x, q.x), std::min(c.low.y, q.y)};
            c.high = {std::max(c.high.x, q.x), std::max(c.high.y, q.y)};
        }
    }
    double scale = size;
    while (!pack(charts, scale, size)) scale *= 0.99;

    std::map<std::pair<int, std::uint32_t>, std::uint32_t> known;  // by chart and vertex
    for (std::size_t f = 0; f < label.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = mesh.polygons[f].vertex[k];
            const auto [entry, fresh] = known.try_emplace({id[f], v}, static_cast<std::uint32_t>(mesh.uvs.size()));
            if (fresh) {
                const Chart& c = charts[static_cast<std::size_t>(id[f])];
                mesh.uvs.push_back((c.origin + (along(mesh.positions[v], c.label) - c.low) * scale) * (1.0 / size));
            }
            mesh.polygons[f].uv[k] = entry->second;
        }
    quantise(mesh);
}

Picture paint_atlas(const PolyMesh& mesh, int size, const std::function<Shade(const Vec3d&)>& shade) {
    Picture out(size, size);
    std::vector<double> outside(out.colour.size(), kGutter);  // how far beyond the triangle that owns the texel
    std::vector<Vec3d> where(out.colour.size());
    for (const Polygon& p : mesh.polygons) {
        std::array<Vec2d, 3> t;
        for (std::size_t k = 0; k < 3; ++k) t[k] = Vec2d{mesh.uvs[p.uv[k]].x, 1 - mesh.uvs[p.uv[k]].y} * size;
        const double twice_area = cross(t[1] - t[0], t[2] - t[0]);
        if (twice_area == 0) continue;
        const auto [x0, x1] = std::minmax({t[0].x, t[1].x, t[2].x});
        const auto [y0, y1] = std::minmax({t[0].y, t[1].y, t[2].y});
        const auto texel = [size](double v) { return std::clamp(static_cast<int>(std::floor(v)), 0, size - 1); };
        for (int y = texel(y0 - kGutter); y <= texel(y1 + kGutter); ++y)
            for (int x = texel(x0 - kGutter); x <= texel(x1 + kGutter); ++x) {
                const Vec2d q{x + 0.5, y + 0.5};
                Vec3d point;
                double beyond = -1e30;
                for (std::size_t k = 0; k < 3; ++k) {
                    const Vec2d a = t[(k + 1) % 3], b = t[(k + 2) % 3];
                    const double weight = cross(b - a, q - a) / twice_area;
                    point += mesh.positions[p.vertex[k]] * weight;
                    beyond = std::max(beyond, -weight * std::abs(twice_area) / length(b - a));
                }
                beyond = std::max(beyond, 0.0);
                if (beyond < outside[out.at(x, y)]) {
                    outside[out.at(x, y)] = beyond;
                    where[out.at(x, y)] = point;
                }
            }
    }
    Colour mean;
    int painted = 0;
    for (std::size_t k = 0; k < where.size(); ++k)
        if (outside[k] < kGutter) {
            const Shade s = shade(where[k]);
            out.colour[k] = s.colour;
            out.relief[k] = s.relief;
            mean += s.colour;
            ++painted;
        }
    for (std::size_t k = 0; k < where.size(); ++k)
        if (outside[k] >= kGutter) out.colour[k] = mean / std::max(painted, 1);
    return out;
}

}  // namespace dgm::samples
