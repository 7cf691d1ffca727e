// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut/distance_queue.h
// Distances along edges that are known already and become less.
#pragma once
#include <cstdint>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

#include "geometry/cut/cut_graph.h"

namespace dgm::bake {

/// Vertices by distance, the nearest first.
using DistanceQueue = std::priority_queue<std::pair<double, std::uint32_t>,
                                          std::vector<std::pair<double, std::uint32_t>>, std::greater<>>;

/// Carries the distances of the vertices in `queue` on, as far as they make others less [Dijkstra 1959] and
/// empties it.
inline void spread(const VertexGraph& graph, DistanceQueue& queue, std::vector<double>& distance) {
    while (!queue.empty()) {
        const auto [d, from] = queue.top();
        queue.pop();
        if (d > distance[from]) continue;
        for (std::uint32_t a = graph.first[from]; a < graph.first[from + 1]; ++a) {
            const VertexGraph::Arc& arc = graph.arcs[a];
            if (!(d + arc.cost < distance[arc.to])) continue;
            distance[arc.to] = d + arc.cost;
            queue.emplace(d + arc.cost, arc.to);
        }
    }
}

}  // namespace dgm::bake
