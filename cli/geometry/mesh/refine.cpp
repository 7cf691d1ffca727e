// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/refine.cpp
// [Rivara 1984] Algorithms for refining triangular grids suitable for adaptive and multigrid techniques. IJNME 20.
#include "geometry/mesh/refine.h"

#include <algorithm>
#include <compare>
#include <cstdint>
#include <queue>
#include <vector>

#include "geometry/mesh/split_edge.h"

namespace dgm::bake {
namespace {

struct Edge {
    double squared;           // length
    std::uint32_t low, high;  // vertices
    std::uint32_t half_edge;  // that joined them when this was queued

    /// True if `other` goes first.
    [[nodiscard]] bool operator<(const Edge& other) const {
        if (squared != other.squared) return squared < other.squared;
        if (low != other.low) return low > other.low;
        if (high != other.high) return high > other.high;
        return half_edge > other.half_edge;
    }
};

Edge edge_of(const TriMesh& mesh, std::uint32_t h) {
    const std::uint32_t a = origin(mesh.faces, h), b = target(mesh.faces, h);
    const Vec3d along = mesh.positions[b] - mesh.positions[a];
    return {dot(along, along), std::min(a, b), std::max(a, b), h};
}

}  // namespace

TriMesh refine(TriMesh mesh, std::size_t faces) {
    std::vector<std::uint32_t> opposite = opposite_half_edges(mesh.faces);
    std::priority_queue<Edge> queue;
    for (std::uint32_t h = 0; h < opposite.size(); ++h)
        if (opposite[h] == kNone || opposite[h] > h) queue.push(edge_of(mesh, h));
    while (mesh.faces.size() < faces && !queue.empty()) {
        const Edge longest = queue.top();
        queue.pop();
        const Edge now = edge_of(mesh, longest.half_edge);
        if (now.low != longest.low || now.high != longest.high) continue;  // split, or moved to another face
        const std::size_t before = mesh.faces.size();
        const std::uint32_t across = opposite[longest.half_edge];
        split_edge(mesh, opposite, longest.half_edge, 0.5);
        const auto queue_face = [&](std::size_t f) {
            for (std::uint32_t k = 0; k < 3; ++k) queue.push(edge_of(mesh, static_cast<std::uint32_t>(3 * f + k)));
        };
        queue_face(longest.half_edge / 3);
        if (across != kNone) queue_face(across / 3);
        for (std::size_t f = before; f < mesh.faces.size(); ++f) queue_face(f);
    }
    return mesh;
}

}  // namespace dgm::bake
