// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut/disk.cpp
#include "geometry/cut/disk.h"

#include <algorithm>
#include <cmath>

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
        if ((hm == kNone) != (gm == kNone)) return true;
        if (hm == kNone) return dot(normalized(edge(h), Vec3d{}), normalized(edge(g), Vec3d{})) < limit;
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
    if (starts.empty()) starts.push_back(0);

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
    }
    return out;
}

NewVertices Disk::split(std::uint32_t h, double t) {
    const NewVertices added = split_edge(mesh, opposite, h, t, &mate);
    weld.push_back(weld_count);
    if (added.twin != kNone) weld.push_back(weld_count);
    ++weld_count;
    return added;
}

}  // namespace dgm::bake
