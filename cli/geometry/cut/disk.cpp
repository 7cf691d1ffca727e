// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut/disk.cpp
#include "geometry/cut/disk.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "math/portable.h"

namespace dgm::bake {

std::vector<std::uint32_t> Disk::border() const {
    std::vector<std::uint32_t> cycle;
    for (std::uint32_t h = 0; h < opposite.size(); ++h) {
        if (opposite[h] != kNone) continue;
        std::uint32_t g = h;
        do {
            cycle.push_back(g);
            g = next_border_half_edge(opposite, g);
        } while (g != h);
        break;
    }
    return cycle;
}

namespace {
/// Marks the paths that join the same two points as others.
void mark_parallel(const Disk& disk, std::vector<BorderPath>& paths) {
    struct Ends {
        std::uint32_t low, high;
        std::size_t path;
        [[nodiscard]] bool same_as(const Ends& o) const { return low == o.low && high == o.high; }
    };
    std::vector<Ends> all;
    for (std::size_t p = 0; p < paths.size(); ++p) {
        if (paths[p].is_loop || (paths[p].mate != kNone && paths[p].mate < p)) continue;
        const std::uint32_t a = disk.weld[origin(disk.mesh.faces, paths[p].half_edges.front())];
        const std::uint32_t b = disk.weld[target(disk.mesh.faces, paths[p].half_edges.back())];
        all.push_back({std::min(a, b), std::max(a, b), p});
    }
    std::sort(all.begin(), all.end(), [](const Ends& a, const Ends& b) {
        return std::tie(a.low, a.high, a.path) < std::tie(b.low, b.high, b.path);
    });
    for (std::size_t k = 0; k < all.size(); ++k) {
        if (!(k > 0 && all[k].same_as(all[k - 1])) && !(k + 1 < all.size() && all[k].same_as(all[k + 1]))) continue;
        BorderPath& path = paths[all[k].path];
        path.parallel = true;
        if (path.mate != kNone) paths[path.mate].parallel = true;
    }
}
}  // namespace

std::vector<BorderPath> Disk::paths(double corner_degrees) const {
    const std::vector<std::uint32_t> cycle = border();
    const std::size_t n = cycle.size();
    if (n == 0) return {};  // a closed surface that nothing cuts
    const double limit = math::cos(corner_degrees * M_PI / 180);
    const auto edge = [&](std::uint32_t h) {
        return mesh.positions[target(mesh.faces, h)] - mesh.positions[origin(mesh.faces, h)];
    };
    // True where a node lies between border edge k and the one after it.
    const auto node_after = [&](std::size_t k) {
        const std::uint32_t h = cycle[k], g = cycle[(k + 1) % n];
        const std::uint32_t hm = mate[h], gm = mate[g];
        if ((hm == kNone) != (gm == kNone) || same_way(h) != same_way(g)) return true;
        if (hm == kNone) return dot(normalized(edge(h), Vec3d{}), normalized(edge(g), Vec3d{})) < limit;
        if (same_way(h)) return next_border_half_edge(opposite, hm) != gm;
        // Mates run backwards: the mate of g must be followed by the mate of h. At a leaf they are each other's mate.
        return hm == g || next_border_half_edge(opposite, gm) != hm;
    };
    std::vector<std::size_t> starts;
    for (std::size_t k = 0; k < n; ++k)
        if (node_after((k + n - 1) % n)) starts.push_back(k);
    // Both sides of a cut path must end at the same vertices: a node seen on one side only (the real border touches the
    // cut from one side) is a node on the other as well.
    std::vector<char> is_node(weld_count, 0);
    for (std::size_t k : starts) is_node[weld[origin(mesh.faces, cycle[k])]] = 1;
    starts.clear();
    for (std::size_t k = 0; k < n; ++k)
        if (is_node[weld[origin(mesh.faces, cycle[k])]]) starts.push_back(k);
    if (starts.empty())  // a smooth real border, or a border that is its own mate from its other half on
        for (std::size_t k = 0; k < n; ++k)
            if (weld[origin(mesh.faces, cycle[k])] == weld[origin(mesh.faces, cycle[0])]) starts.push_back(k);

    std::vector<BorderPath> out(starts.size());
    std::vector<std::uint32_t> path_of(opposite.size(), kNone);
    for (std::size_t p = 0; p < starts.size(); ++p) {
        const std::size_t end = p + 1 < starts.size() ? starts[p + 1] : starts[0] + n;
        for (std::size_t k = starts[p]; k < end; ++k) {
            const std::uint32_t h = cycle[k % n];
            out[p].half_edges.push_back(h);
            out[p].length += length(edge(h));
            path_of[h] = static_cast<std::uint32_t>(p);
        }
        out[p].is_loop =
            weld[origin(mesh.faces, out[p].half_edges.front())] == weld[target(mesh.faces, out[p].half_edges.back())];
    }
    for (BorderPath& path : out) {
        const std::uint32_t m = mate[path.half_edges.front()];
        if (m != kNone) path.mate = path_of[m];
        path.same_way = same_way(path.half_edges.front());
    }
    mark_parallel(*this, out);
    return out;
}

void Disk::join_sides() {
    if (mesh.points.empty()) return;
    std::vector<std::uint32_t> lowest(weld_count, kNone);
    for (std::size_t v = 0; v < weld.size(); ++v) {
        std::uint32_t& id = lowest[mesh.points[v]];
        id = std::min(id, weld[v]);
    }
    for (std::size_t v = 0; v < weld.size(); ++v) weld[v] = lowest[mesh.points[v]];
    mesh.points.clear();
    struct Side {
        std::uint32_t from, to, half_edge;
    };
    std::vector<Side> sides;
    for (std::uint32_t h = 0; h < opposite.size(); ++h)
        if (opposite[h] == kNone && mate[h] == kNone)
            sides.push_back({weld[origin(mesh.faces, h)], weld[target(mesh.faces, h)], h});
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::tie(a.from, a.to, a.half_edge) < std::tie(b.from, b.to, b.half_edge);
    });
    for (std::size_t k = 0; k + 1 < sides.size(); ++k) {
        if (sides[k].from != sides[k + 1].from || sides[k].to != sides[k + 1].to) continue;
        mate[sides[k].half_edge] = sides[k + 1].half_edge;
        mate[sides[k + 1].half_edge] = sides[k].half_edge;
        ++k;
    }
}

std::vector<std::uint8_t> Disk::reversed_vertices() const {
    struct Link {
        std::uint32_t from, to;
        std::uint8_t reverses;
    };
    std::vector<Link> links;
    bool any = false;
    for (std::uint32_t h = 0; h < mate.size(); ++h) {
        if (mate[h] == kNone) continue;
        const std::uint32_t a = origin(mesh.faces, h), b = target(mesh.faces, h);
        const std::uint32_t c = origin(mesh.faces, mate[h]), d = target(mesh.faces, mate[h]);
        const bool same = same_way(h);
        any = any || same;
        links.push_back({a, same ? c : d, same});
        links.push_back({b, same ? d : c, same});
    }
    if (!any) return {};
    std::sort(links.begin(), links.end(), [](const Link& l, const Link& r) { return l.from < r.from; });
    constexpr std::uint8_t kUnknown = 2;
    std::vector<std::uint8_t> out(weld.size(), kUnknown);
    std::vector<std::uint32_t> walk;
    for (std::uint32_t first = 0; first < out.size(); ++first) {
        if (out[first] != kUnknown) continue;
        out[first] = 0;
        walk.assign(1, first);
        for (std::size_t at = 0; at < walk.size(); ++at) {
            auto link = std::lower_bound(links.begin(), links.end(), walk[at],
                                         [](const Link& l, std::uint32_t v) { return l.from < v; });
            for (; link != links.end() && link->from == walk[at]; ++link) {
                if (out[link->to] != kUnknown) continue;
                out[link->to] = out[walk[at]] ^ link->reverses;
                walk.push_back(link->to);
            }
        }
    }
    return out;
}

NewVertices Disk::split(std::uint32_t h, double t) {
    const NewVertices added = split_edge(mesh, opposite, h, t, &mate, same_way(h));
    weld.push_back(weld_count);
    if (added.twin != kNone) weld.push_back(weld_count);
    if (!mesh.points.empty())  // numbered as `weld` here
        for (std::size_t v = added.vertex; v < weld.size(); ++v) mesh.points[v] = weld_count;
    ++weld_count;
    return added;
}

}  // namespace dgm::bake
