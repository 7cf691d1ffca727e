// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/fit_rows.cpp
#include "geometry/fit/fit_rows.h"

#include <algorithm>
#include <cmath>

namespace dgm::bake {
namespace {

// Chosen by measurement on organs, busts and animals.
constexpr double kWorstShare = 0.6, kUrgency = 200;  // of the largest error, where a pull begins, and how steeply
constexpr double kFading = 0.5;                      // of a pull, from one round to the next
constexpr double kBorderShare = 0.1;  // weight of a sample's part of the border, in those of its source points

bool is_inside(const std::array<double, 3>& b) {
    return b[0] > 1e-9 && b[1] > 1e-9 && b[2] > 1e-9;
}

/// Normal of the metric: the surface's, but along the gap where the closest point is on an edge of the face.
Vec3d metric_normal(const Vec3d& gap, const Vec3d& face, const std::array<double, 3>& b) {
    return is_inside(b) ? face : normalized(gap, face);
}

}  // namespace

void FitRows::assemble(NormalEquations& equations, bool worst_only, std::span<const char> near) {
    const double farthest = worst_only ? std::max(matches_.largest, rails_.largest_gap()) : 0;
    const auto excess = [&](double squared) {
        return farthest > 0 ? kUrgency * std::max(0.0, std::sqrt(squared) / farthest - kWorstShare) : 0;
    };
    const auto urgency = [&](std::vector<double>& pulls, const std::vector<Match>& list, std::size_t k) {
        if (!worst_only) return 1.0;
        pulls.resize(list.size(), 0);
        pulls[k] = std::max(excess(list[k].hit.squared), kFading * pulls[k]);
        return 1 + pulls[k];
    };
    const LinkedSurface& grid = grid_.surface;
    for (std::size_t k = 0; k < matches_.points.size(); ++k) {
        const Match& m = matches_.points[k];
        if (!near.empty() && !near[m.hit.face]) continue;
        const Vec3d gap = m.position - point_at(grid, m.hit), &normal = grid.normals[m.hit.face];
        const double weight = m.weight * urgency(pulls_[0], matches_.points, k);
        if (is_inside(m.hit.b))
            equations.add_along_normal(m.hit.face, m.hit.b, dot(normal, gap), weight);
        else
            equations.add(m.hit.face, m.hit.b, gap, normalized(gap, normal), weight);
    }
    equations.close();
    const auto add_back = [&](const Match& m, double weight, std::uint32_t face, const std::array<double, 3>& b) {
        const Vec3d gap = point_at(source_, m.hit) - m.position;
        equations.add(face, b, gap, metric_normal(gap, source_.normals[m.hit.face], m.hit.b), weight);
    };
    for (std::size_t e = 0; e < matches_.edges.size(); ++e) {
        const double pull = urgency(pulls_[1], matches_.edges, e);
        if (!(pull > 1)) continue;
        const auto [face, k] = matches_.edge_place[e];
        if (!near.empty() && !near[face]) continue;
        std::array<double, 3> b{0, 0, 0};
        b[k] = b[(k + 1) % 3] = 0.5;
        add_back(matches_.edges[e], matches_.middles[face].weight / 2 * pull, face, b);
    }
    std::vector<char> done(matches_.classes.size(), 0);
    for (std::uint32_t f = 0; f < grid.faces.size(); ++f) {
        if (!near.empty() && !near[f]) continue;
        const Match& middle = matches_.middles[f];
        add_back(middle, middle.weight * urgency(pulls_[2], matches_.middles, f), f, {1.0 / 3, 1.0 / 3, 1.0 / 3});
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t c = grid.faces[f][k];
            if (done[c]) continue;
            done[c] = 1;
            std::array<double, 3> b{0, 0, 0};
            b[k] = 1;
            const Match& corner = matches_.classes[c];
            add_back(corner, corner.weight * urgency(pulls_[3], matches_.classes, c), f, b);
        }
    }
    if (!rails_.empty() && near.empty())
        rails_.add_rows(equations, kBorderShare * points_per_sample_,
                        [&](double squared) { return 1 + excess(squared); });
}

}  // namespace dgm::bake
