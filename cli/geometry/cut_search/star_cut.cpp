// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/star_cut.cpp
#include "geometry/cut_search/star_cut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

#include "geometry/mesh/infinity.h"
#include "geometry/parameterize/spherical_map.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {

constexpr double kStray = 8;      // cost of an edge a radian off its great arc, in lengths
constexpr double kBehind = -0.2;  // cosine: farther from the end of its arm than a right angle and some

/// The middle of the star and the ends of its arms, counter-clockwise about it seen from outside.
struct Octahedron {
    Vec3d pole;
    std::array<Vec3d, 4> ends;
};

/// Poles on a spiral [Vogel 1979], each turned by another multiple of the golden angle.
Octahedron octahedron(std::size_t k, std::size_t count) {
    const double golden = M_PI * (3 - std::sqrt(5.0));
    const double z = 1 - (2 * static_cast<double>(k) + 1) / static_cast<double>(count), r = std::sqrt(1 - z * z);
    const double at = golden * static_cast<double>(k);
    Octahedron out;
    out.pole = {r * math::cos(at), r * math::sin(at), z};
    const Vec3d east{-math::sin(at), math::cos(at), 0}, north = cross(out.pole, east);
    for (std::size_t a = 0; a < 4; ++a) {
        const double turn = golden * static_cast<double>(k) + M_PI / 2 * static_cast<double>(a);
        out.ends[a] = east * math::cos(turn) + north * math::sin(turn);
    }
    return out;
}

std::uint32_t nearest(const std::vector<Vec3d>& sphere, const Vec3d& to) {
    const auto farther = [&](const Vec3d& a, const Vec3d& b) { return dot(a, to) < dot(b, to); };
    return static_cast<std::uint32_t>(std::max_element(sphere.begin(), sphere.end(), farther) - sphere.begin());
}

/// Marks the way from `from` to `to` that stays nearest to the arc from `end` to `pole`, over vertices that are free;
/// takes those of the way. False if there is none.
bool mark_arm(CutGraph& cut, const std::vector<Vec3d>& sphere, std::uint32_t from, std::uint32_t to, const Vec3d& pole,
              const Vec3d& end, std::vector<char>& taken) {
    const Vec3d side = cross(pole, end);
    const VertexGraph& graph = cut.graph();
    std::vector<double> distance(sphere.size(), kInfinity);
    std::vector<std::uint32_t> arc(sphere.size(), kNone), before(sphere.size(), kNone);
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    distance[from] = 0;
    queue.emplace(0.0, from);
    while (!queue.empty() && queue.top().second != to) {
        const auto [d, v] = queue.top();
        queue.pop();
        if (d > distance[v]) continue;
        for (std::uint32_t a = graph.first[v]; a < graph.first[v + 1]; ++a) {
            const std::uint32_t w = graph.arcs[a].to;
            if ((taken[w] && w != to) || dot(sphere[w], end) < kBehind) continue;
            const double off = 0.5 * std::abs(dot(sphere[v] + sphere[w], side));
            const double there = d + length(sphere[w] - sphere[v]) * (1 + kStray * off);
            if (there < distance[w]) {
                distance[w] = there;
                arc[w] = a;
                before[w] = v;
                queue.emplace(there, w);
            }
        }
    }
    if (queue.empty()) return false;
    for (std::uint32_t v = to; v != from; v = before[v]) {
        cut.mark(graph.arcs[arc[v]].half_edge, true);
        taken[v] = 1;
    }
    return true;
}

}  // namespace

std::vector<CutGraph> star_cuts(const TriMesh& component, std::size_t how_many, const model::Progress& progress) {
    const std::vector<Vec3d> sphere = spherical_map(component, {}, progress);
    const CutGraph uncut(component);
    std::vector<CutGraph> out;
    for (std::size_t k = 0; k < how_many; ++k) {
        const Octahedron o = octahedron(k, how_many);
        CutGraph cut = uncut;
        const std::uint32_t middle = nearest(sphere, o.pole);
        std::vector<char> taken(sphere.size(), 0);
        taken[middle] = 1;
        std::array<std::uint32_t, 4> ends;
        bool whole = true;
        for (std::size_t a = 0; a < 4; ++a) {
            ends[a] = nearest(sphere, o.ends[a]);
            whole = whole && !taken[ends[a]];
            taken[ends[a]] = 1;
        }
        for (std::size_t a = 0; a < 4 && whole; ++a)
            whole = mark_arm(cut, sphere, ends[a], middle, o.pole, o.ends[a], taken);
        if (whole) out.push_back(std::move(cut));
    }
    return out;
}

}  // namespace dgm::bake
