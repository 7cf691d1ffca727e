// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/ring_cut.cpp
#include "geometry/cut_search/ring_cut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <queue>
#include <span>
#include <utility>

#include "geometry/mesh/infinity.h"
#include "geometry/metrics/map_metrics.h"

namespace dgm::bake {
namespace {

/// One border loop: its vertices in order, and the length of the border up to each.
struct Loop {
    std::vector<std::uint32_t> vertices;
    std::vector<double> at;
    double length = 0;
};

Loop loop_from(const CutGraph& uncut, std::uint32_t first) {
    const TriMesh& mesh = uncut.mesh();
    Loop out;
    std::uint32_t h = first;
    do {
        out.vertices.push_back(origin(mesh.faces, h));
        out.at.push_back(out.length);
        out.length += length(mesh.positions[target(mesh.faces, h)] - mesh.positions[origin(mesh.faces, h)]);
        h = next_border_half_edge(uncut.opposite(), h);
    } while (h != first);
    return out;
}

/// The vertex of the loop nearest to `at` along it.
std::size_t place_on(const Loop& loop, double at) {
    const auto after = std::lower_bound(loop.at.begin(), loop.at.end(), at);
    if (after == loop.at.begin()) return 0;
    const auto k = static_cast<std::size_t>(after - loop.at.begin());
    const double next = after == loop.at.end() ? loop.length : *after;
    return at - loop.at[k - 1] <= next - at ? k - 1 : k % loop.at.size();
}

/// Half-edges of the shortest path from one of `from` to the nearest of `to` that touches both loops nowhere else;
/// the end at `from` first. Empty if there is none.
std::vector<std::uint32_t> path_between(const CutGraph& uncut, std::span<const std::uint32_t> from, const Loop& own,
                                        const Loop& other) {
    const VertexGraph& graph = uncut.graph();
    const std::vector<Face>& faces = uncut.mesh().faces;
    std::vector<double> distance(uncut.mesh().positions.size(), kInfinity);
    std::vector<std::uint32_t> arc(distance.size(), kNone);
    std::vector<char> closed(distance.size(), 0), reached(distance.size(), 0);
    for (const std::uint32_t v : own.vertices) closed[v] = 1;
    for (const std::uint32_t v : other.vertices) reached[v] = 1;
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    for (const std::uint32_t v : from) {
        distance[v] = 0;
        queue.emplace(0.0, v);
    }
    while (!queue.empty() && !reached[queue.top().second]) {
        const auto [d, v] = queue.top();
        queue.pop();
        if (d > distance[v]) continue;
        for (std::uint32_t a = graph.first[v]; a < graph.first[v + 1]; ++a) {
            const VertexGraph::Arc& to = graph.arcs[a];
            if (closed[to.to] || !(d + to.length < distance[to.to])) continue;
            distance[to.to] = d + to.length;
            arc[to.to] = to.half_edge;
            queue.emplace(distance[to.to], to.to);
        }
    }
    std::vector<std::uint32_t> path;
    if (queue.empty()) return path;
    for (std::uint32_t v = queue.top().second; arc[v] != kNone;) {
        const std::uint32_t h = arc[v];
        path.push_back(h);
        v = origin(faces, h) == v ? target(faces, h) : origin(faces, h);
    }
    std::reverse(path.begin(), path.end());
    return path;
}

}  // namespace

bool is_ring(const TriMesh& component) {
    if (!component.points.empty()) return false;  // a surface with one side, opened
    const Topology topology = measure_topology(component.positions.size(), component.faces);
    return topology.components == 1 && topology.manifold && topology.genus == 0 && topology.boundary_loops == 2;
}

std::vector<CutGraph> ring_cuts(const TriMesh& component, std::size_t how_many) {
    if (how_many == 0 || !is_ring(component)) return {};
    const CutGraph uncut(component);
    const std::vector<std::uint32_t> starts = boundary_loops(uncut.opposite());
    std::array<Loop, 2> loops{loop_from(uncut, starts[0]), loop_from(uncut, starts[1])};
    if (loops[1].length > loops[0].length) std::swap(loops[0], loops[1]);
    const auto& [longer, shorter] = loops;

    std::vector<std::vector<std::uint32_t>> paths{path_between(uncut, longer.vertices, longer, shorter)};
    if (paths.front().empty()) return {};
    const std::uint32_t h = paths.front().front(), a = origin(component.faces, h);
    const std::uint32_t begin =
        std::count(longer.vertices.begin(), longer.vertices.end(), a) != 0 ? a : target(component.faces, h);
    const auto first = std::find(longer.vertices.begin(), longer.vertices.end(), begin) - longer.vertices.begin();
    for (std::size_t k = 1; k < how_many; ++k) {
        const double at = longer.at[static_cast<std::size_t>(first)] +
                          longer.length * static_cast<double>(k) / static_cast<double>(how_many);
        const std::uint32_t from = longer.vertices[place_on(longer, std::fmod(at, longer.length))];
        std::vector<std::uint32_t> path = path_between(uncut, std::span(&from, 1), longer, shorter);
        if (!path.empty() && std::find(paths.begin(), paths.end(), path) == paths.end())
            paths.push_back(std::move(path));
    }
    std::vector<CutGraph> out(paths.size(), uncut);
    for (std::size_t k = 0; k < paths.size(); ++k)
        for (const std::uint32_t half_edge : paths[k]) out[k].mark(half_edge, true);
    return out;
}

}  // namespace dgm::bake
