// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/metrics/topology.cpp
// Topology by counting: nothing is assumed of the faces, but that there are fewer than 2^32 / 3.
#include <algorithm>
#include <vector>

#include "geometry/mesh/half_edges.h"
#include "geometry/mesh/union_find.h"
#include "geometry/metrics/map_metrics.h"

namespace dgm::bake {
namespace {
using model::Face;

struct EdgeUse {
    std::uint32_t low, high;
    std::uint32_t corner;  // 3 * face + k: the edge runs from corner k to corner k + 1
    bool forward;          // from low to high
    friend bool operator<(const EdgeUse& a, const EdgeUse& b) {
        if (a.low != b.low) return a.low < b.low;
        if (a.high != b.high) return a.high < b.high;
        return a.corner < b.corner;
    }
    [[nodiscard]] bool same_edge(const EdgeUse& o) const { return low == o.low && high == o.high; }
};

/// Sorts by the operator above: by `low` through counting, since there are few uses of each.
void sort_uses(std::vector<EdgeUse>& uses, std::size_t vertex_count) {
    std::vector<std::size_t> next(vertex_count + 1, 0);
    for (const EdgeUse& use : uses) ++next[use.low + 1];
    for (std::size_t v = 0; v < vertex_count; ++v) next[v + 1] += next[v];
    std::vector<EdgeUse> sorted(uses.size());
    for (const EdgeUse& use : uses) sorted[next[use.low]++] = use;
    // next[v] is now the end of the uses of v.
    for (std::size_t v = 0, first = 0; v < vertex_count; first = next[v++])
        std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(first),
                  sorted.begin() + static_cast<std::ptrdiff_t>(next[v]));
    uses = std::move(sorted);
}

std::uint32_t next_in_face(std::uint32_t corner) {
    return corner - corner % 3 + (corner % 3 + 1) % 3;
}
std::uint32_t corner_at_low(const EdgeUse& e) {
    return e.forward ? e.corner : next_in_face(e.corner);
}
std::uint32_t corner_at_high(const EdgeUse& e) {
    return e.forward ? next_in_face(e.corner) : e.corner;
}

bool is_degenerate(const Face& face, std::size_t vertex_count) {
    const bool in_range = face[0] < vertex_count && face[1] < vertex_count && face[2] < vertex_count;
    return !in_range || face[0] == face[1] || face[1] == face[2] || face[2] == face[0];
}

/// The edges of the faces that are not degenerate, and the vertices that they use.
struct EdgeUses {
    std::vector<EdgeUse> uses;  ///< sorted: those of one edge are neighbours
    std::uint64_t faces = 0, vertices = 0, components = 0;
};

EdgeUses collect_uses(std::size_t vertex_count, std::span<const Face> faces) {
    EdgeUses out;
    out.uses.reserve(3 * faces.size());
    std::vector<std::uint8_t> in_use(vertex_count, 0);
    UnionFind components(vertex_count);
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        const Face& face = faces[f];
        if (is_degenerate(face, vertex_count)) continue;
        ++out.faces;
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t from = face[k], to = face[(k + 1) % 3];
            out.uses.push_back({std::min(from, to), std::max(from, to), 3 * f + k, from < to});
            in_use[from] = 1;
        }
        components.unite(face[0], face[1]);
        components.unite(face[0], face[2]);
    }
    sort_uses(out.uses, vertex_count);
    for (std::uint32_t v = 0; v < vertex_count; ++v) {
        if (in_use[v] == 0) continue;
        ++out.vertices;
        if (components.find(v) == v) ++out.components;
    }
    return out;
}

/// How the faces meet. A fan is a class of face corners at one vertex, joined across edges with exactly two faces.
struct Edges {
    UnionFind fans;
    std::vector<std::uint32_t> border;  ///< the use of each edge with one face
    std::uint64_t count = 0;
    bool manifold = true, oriented = true;
};

Edges join_fans(const std::vector<EdgeUse>& uses, std::size_t face_count) {
    Edges out{UnionFind(3 * face_count), {}};
    for (std::uint32_t e = 0, end = 0; e < uses.size(); e = end, ++out.count) {
        for (end = e + 1; end < uses.size() && uses[end].same_edge(uses[e]);) ++end;
        if (end - e == 1) {
            out.border.push_back(e);
        } else if (end - e == 2) {
            if (uses[e].forward == uses[e + 1].forward) out.oriented = false;
            out.fans.unite(corner_at_low(uses[e]), corner_at_low(uses[e + 1]));
            out.fans.unite(corner_at_high(uses[e]), corner_at_high(uses[e + 1]));
        } else {
            out.manifold = false;
        }
    }
    return out;
}

bool one_fan_a_vertex(const std::vector<EdgeUse>& uses, UnionFind& fans, std::size_t vertex_count) {
    std::vector<std::uint32_t> fan_of(vertex_count, kNone);
    for (const EdgeUse& use : uses) {
        const std::uint32_t vertex = use.forward ? use.low : use.high;
        const std::uint32_t fan = fans.find(use.corner);
        if (fan_of[vertex] == kNone) fan_of[vertex] = fan;
        if (fan_of[vertex] != fan) return false;
    }
    return true;
}

/// Border edges that end in the same fan follow each other on a loop.
std::uint64_t count_loops(const std::vector<EdgeUse>& uses, Edges& edges, std::size_t face_count) {
    const std::vector<std::uint32_t>& border = edges.border;
    if (border.empty()) return 0;
    UnionFind loops(border.size());
    std::vector<std::uint32_t> first_at_fan(3 * face_count, kNone);
    for (std::uint32_t k = 0; k < border.size(); ++k)
        for (const std::uint32_t corner : {corner_at_low(uses[border[k]]), corner_at_high(uses[border[k]])}) {
            std::uint32_t& first = first_at_fan[edges.fans.find(corner)];
            if (first == kNone) first = k;
            loops.unite(first, k);
        }
    std::uint64_t count = 0;
    for (std::uint32_t k = 0; k < border.size(); ++k)
        if (loops.find(k) == k) ++count;
    return count;
}
}  // namespace

Topology measure_topology(std::size_t vertex_count, std::span<const Face> faces) {
    const EdgeUses used = collect_uses(vertex_count, faces);
    Edges edges = join_fans(used.uses, faces.size());
    Topology out;
    out.degenerate_faces = faces.size() - used.faces;
    out.components = used.components;
    out.manifold = edges.manifold && one_fan_a_vertex(used.uses, edges.fans, vertex_count);
    out.oriented = edges.oriented;
    out.boundary_loops = count_loops(used.uses, edges, faces.size());
    // Sum over components of 2 - 2g - b = V - E + F, or of 2 - g - b without an orientation.
    if (out.manifold) {
        const std::int64_t euler = static_cast<std::int64_t>(used.vertices) - static_cast<std::int64_t>(edges.count) +
                                   static_cast<std::int64_t>(used.faces);
        out.genus =
            2 * static_cast<std::int64_t>(out.components) - euler - static_cast<std::int64_t>(out.boundary_loops);
        if (out.oriented) out.genus /= 2;
    }
    return out;
}

Topology measure_topology(const model::TriMesh& component) {
    if (component.points.empty()) return measure_topology(component.positions.size(), component.faces);
    std::vector<Face> faces = component.faces;
    for (Face& f : faces)
        for (std::uint32_t& v : f) v = component.points[v];
    return measure_topology(component.positions.size(), faces);
}

}  // namespace dgm::bake
