// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/fit_rows.cpp
#include "geometry/fit/fit_rows.h"

#include <tbb/parallel_invoke.h>

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

/// One call of assemble(). Points and faces are summed up side by side: they touch different sums and pulls.
struct FitRows::Round {
    FitRows& rows;
    NormalEquations& equations;
    std::span<const char> near;
    double farthest;  // 0: all rows pull alike

    [[nodiscard]] bool is_near(std::uint32_t face) const { return near.empty() || near[face] != 0; }
    [[nodiscard]] double excess(double squared) const {
        return farthest > 0 ? kUrgency * std::max(0.0, std::sqrt(squared) / farthest - kWorstShare) : 0;
    }
    [[nodiscard]] double urgency(int kind, const std::vector<Match>& list, std::size_t k) const {
        if (!(farthest > 0)) return 1;
        std::vector<double>& pulls = rows.pulls_[static_cast<std::size_t>(kind)];
        pulls.resize(list.size(), 0);
        pulls[k] = std::max(excess(list[k].hit.squared), kFading * pulls[k]);
        return 1 + pulls[k];
    }

    void add_points() const {
        const LinkedSurface& grid = rows.grid_.surface;
        const std::vector<Match>& points = rows.matches_.points;
        for (std::size_t k = 0; k < points.size(); ++k) {
            const Match& m = points[k];
            if (!is_near(m.hit.face)) continue;
            const Vec3d gap = m.position - point_at(grid, m.hit), &normal = grid.normals[m.hit.face];
            const double weight = m.weight * urgency(0, points, k);
            if (is_inside(m.hit.b))
                equations.add_along_normal(m.hit.face, m.hit.b, dot(normal, gap), weight);
            else
                equations.add_later(m.hit.face, m.hit.b, gap, normalized(gap, normal), weight);
        }
    }

    [[nodiscard]] Vec3d gap_of(const Match& m) const { return point_at(rows.source_, m.hit) - m.position; }
    [[nodiscard]] Vec3d normal_of(const Match& m, const Vec3d& gap) const {
        return metric_normal(gap, rows.source_.normals[m.hit.face], m.hit.b);
    }

    void add_edges() const {
        const Matches& matches = rows.matches_;
        for (std::size_t e = 0; e < matches.edges.size(); ++e) {
            const double pull = urgency(1, matches.edges, e);
            if (!(pull > 1)) continue;
            const auto [face, k] = matches.edge_place[e];
            if (!is_near(face)) continue;
            std::array<double, 3> b{0, 0, 0};
            b[k] = b[(k + 1) % 3] = 0.5;
            const Vec3d gap = gap_of(matches.edges[e]);
            equations.add(face, b, gap, normal_of(matches.edges[e], gap), matches.middles[face].weight / 2 * pull);
        }
    }

    void add_faces() const {
        const Matches& matches = rows.matches_;
        std::vector<char> is_far(near.empty() ? 0 : matches.classes.size(), 1);
        for (std::uint32_t f = 0; f < matches.middles.size(); ++f) {
            if (!is_near(f)) continue;
            const Match& middle = matches.middles[f];
            const Vec3d gap = gap_of(middle);
            equations.add_at_middle(f, gap, normal_of(middle, gap), middle.weight * urgency(2, matches.middles, f));
            if (!near.empty())
                for (const std::uint32_t c : rows.grid_.surface.faces[f]) is_far[c] = 0;
        }
        for (std::uint32_t c = 0; c < matches.classes.size(); ++c) {
            if (!is_far.empty() && is_far[c]) continue;
            const Match& corner = matches.classes[c];
            const Vec3d gap = gap_of(corner);
            equations.add_at_class(c, gap, normal_of(corner, gap), corner.weight * urgency(3, matches.classes, c));
        }
    }
};

void FitRows::assemble(NormalEquations& equations, bool worst_only, std::span<const char> near, bool with_border) {
    const Round round{*this, equations, near, worst_only ? std::max(matches_.largest, rails_.largest_gap()) : 0};
    tbb::parallel_invoke([&] { round.add_points(); },
                         [&] {
                             round.add_edges();
                             round.add_faces();
                         });
    equations.close();
    if (!rails_.empty() && with_border)
        rails_.add_rows(equations, kBorderShare * points_per_sample_,
                        [&](double squared) { return 1 + round.excess(squared); });
}

}  // namespace dgm::bake
