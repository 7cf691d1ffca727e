// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/source_edges.cpp
#include "geometry/fit/source_edges.h"

#include <algorithm>
#include <cmath>

#include "geometry/mesh/triangle.h"

namespace dgm::bake {
namespace {

constexpr double kSharp = 4;             // sine of an edge that counts, in the error over the spacing
constexpr double kSharpest = 0.9;        // sine from which each edge counts
constexpr double kStep = 0.25;           // between points of an edge, in the spacing
constexpr double kMostSteps = 1000;      // of an edge
constexpr std::size_t kPointsOfAll = 8;  // of all edges, a class
constexpr std::size_t kMostEdges = 4;    // of a class

}  // namespace

SourceEdges::SourceEdges(FitState& fit, double rms, double spacing) : fit_(fit), spacing_(spacing) {
    std::vector<Pair> pairs = lay_over_grid(std::min(kSharpest, kSharp * rms / spacing));
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    list_nearest(pairs);
}

std::pair<Vec3d, Vec3d> SourceEdges::ends(std::uint32_t half_edge) const {
    const Face& f = fit_.source.faces[half_edge / 3];
    return {fit_.source.positions[f[half_edge % 3]], fit_.source.positions[f[(half_edge + 1) % 3]]};
}

Vec3d SourceEdges::foot(std::uint32_t half_edge, const Vec3d& from) const {
    const auto [a, b] = ends(half_edge);
    double t = 0;
    closest_on_segment(from, a, b - a, t);
    return t <= 0 ? a : t >= 1 ? b : a + (b - a) * t;
}

std::vector<Vec3d> SourceEdges::places(std::uint32_t c, const Vec3d& from) const {
    std::vector<Vec3d> out;
    const auto add = [&](const Vec3d& p) {
        if (p != from && std::find(out.begin(), out.end(), p) == out.end()) out.push_back(p);
    };
    for (std::uint32_t k = first_[c]; k < first_[c + 1]; ++k) {
        add(foot(edges_[k], from));
        const auto [a, b] = ends(edges_[k]);
        if (length(a - from) < spacing_) add(a);
        if (length(b - from) < spacing_) add(b);
    }
    return out;
}

/// Per point of the source the face of the grid that its vertex is matched to: the vertices follow the other points of
/// the matches, in the order of the disk's vertices (Matches).
std::vector<std::uint32_t> SourceEdges::faces_over_vertices() const {
    std::vector<std::uint32_t> out(fit_.source.positions.size(), kNone);
    std::size_t k = fit_.matches.area_points;
    for (const std::uint32_t point : fit_.chart.disk->weld)
        if (out[point] == kNone) out[point] = fit_.matches.points[k++].hit.face;
    return out;
}

/// Each edge with the classes that it passes.
/// @param sine  of the angle between an edge's faces, from which it counts
std::vector<SourceEdges::Pair> SourceEdges::lay_over_grid(double sine) const {
    const LinkedSurface& source = fit_.source;
    const LinkedSurface& grid = fit_.grid.surface;
    const std::vector<std::uint32_t> over_vertex = faces_over_vertices();
    std::size_t points_left = kPointsOfAll * grid.positions.size();
    std::uint64_t looked = 0;
    std::vector<Pair> out;
    for (std::uint32_t half_edge = 0; half_edge < 3 * source.faces.size(); ++half_edge) {
        const std::uint32_t face = half_edge / 3, other = source.neighbours[face][half_edge % 3];
        if (other == kNone || other < face) continue;
        const double cosine = dot(source.normals[face], source.normals[other]);
        if (cosine > 0 && 1 - cosine * cosine < sine * sine) continue;
        const auto [a, b] = ends(half_edge);
        const int steps = 1 + static_cast<int>(std::min(kMostSteps, length(b - a) / (kStep * spacing_)));
        std::uint32_t at = over_vertex[source.faces[face][half_edge % 3]];
        for (int k = 0; k <= steps && points_left > 0; ++k, --points_left) {
            at = walk_to_closest(grid, a + (b - a) * (static_cast<double>(k) / steps), at, &looked).face;
            for (const std::uint32_t c : grid.faces[at])
                if (!fit_.fixed[c]) out.emplace_back(c, half_edge);
        }
    }
    fit_.matches.count_looks(looked);
    return out;
}

void SourceEdges::list_nearest(const std::vector<Pair>& pairs) {
    const std::vector<Vec3d>& positions = fit_.grid.surface.positions;
    std::vector<std::pair<double, std::uint32_t>> near;
    for (std::size_t c = 0, k = 0; c < positions.size(); ++c) {
        first_.push_back(static_cast<std::uint32_t>(edges_.size()));
        near.clear();
        for (; k < pairs.size() && pairs[k].first == c; ++k) {
            const Vec3d way = foot(pairs[k].second, positions[c]) - positions[c];
            near.emplace_back(dot(way, way), pairs[k].second);
        }
        std::sort(near.begin(), near.end());
        near.resize(std::min(near.size(), kMostEdges));
        for (const auto& [squared, half_edge] : near) edges_.push_back(half_edge);
    }
    first_.push_back(static_cast<std::uint32_t>(edges_.size()));
}

}  // namespace dgm::bake
