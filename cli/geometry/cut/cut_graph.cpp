// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut/cut_graph.cpp
#include "geometry/cut/cut_graph.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "geometry/cut/distance_queue.h"
#include "geometry/mesh/infinity.h"
#include "geometry/mesh/union_find.h"

namespace dgm::bake {
namespace {

std::uint32_t place_of_largest(const std::vector<double>& distance) {
    return static_cast<std::uint32_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
}

VertexGraph build_graph(const TriMesh& mesh, std::span<const std::uint32_t> opposite) {
    VertexGraph g;
    g.first.assign(mesh.positions.size() + 1, 0);
    const auto each_edge = [&](auto visit) {
        for (std::uint32_t h = 0; h < opposite.size(); ++h)
            if (opposite[h] == kNone || h < opposite[h]) visit(h, origin(mesh.faces, h), target(mesh.faces, h));
    };
    each_edge([&](std::uint32_t, std::uint32_t a, std::uint32_t b) {
        ++g.first[a + 1];
        ++g.first[b + 1];
    });
    for (std::size_t v = 1; v < g.first.size(); ++v) g.first[v] += g.first[v - 1];
    g.arcs.resize(g.first.back());
    std::vector<std::uint32_t> fill(g.first.begin(), g.first.end() - 1);
    each_edge([&](std::uint32_t h, std::uint32_t a, std::uint32_t b) {
        const double l = length(mesh.positions[a] - mesh.positions[b]);
        g.arcs[fill[a]++] = {b, h, l, l};
        g.arcs[fill[b]++] = {a, h, l, l};
    });
    return g;
}

/// The vertex farthest from the mean of all: the same one, whatever the order of faces and vertices. The first of those
/// that are as far but for rounding, as all of a sphere are.
std::uint32_t outermost(std::span<const Vec3d> positions) {
    constexpr double kRounding = 1e-9;
    Vec3d sum{};
    for (const Vec3d& p : positions) sum = sum + p;
    const Vec3d mean = sum / static_cast<double>(positions.size());
    const auto squared = [&](const Vec3d& p) { return dot(p - mean, p - mean); };
    double most = 0;
    for (const Vec3d& p : positions) most = std::max(most, squared(p));
    const auto it = std::find_if(positions.begin(), positions.end(),
                                 [&](const Vec3d& p) { return squared(p) >= (1 - kRounding) * most; });
    return static_cast<std::uint32_t>(it - positions.begin());
}

}  // namespace

CutGraph::CutGraph(const TriMesh& component)
    : mesh_(&component),
      opposite_(opposite_half_edges(component.faces)),
      graph_(build_graph(component, opposite_)),
      loops_(boundary_loops(opposite_)),
      cut_(opposite_.size(), 0) {
    const auto v = static_cast<std::int64_t>(component.positions.size());
    const auto e = static_cast<std::int64_t>(graph_.arcs.size() / 2);
    const auto f = static_cast<std::int64_t>(component.faces.size());
    genus_ = (2 - (v - e + f) - static_cast<std::int64_t>(loops_.size())) / 2;
}

template <class Stop>
std::uint32_t CutGraph::search(std::span<const std::uint32_t> sources, Stop stop, Search& out,
                               std::span<const char> closed) const {
    out.distance.assign(mesh_->positions.size(), kInfinity);
    out.arc.assign(mesh_->positions.size(), kNone);
    DistanceQueue queue;
    for (std::uint32_t s : sources) {
        out.distance[s] = 0;
        queue.emplace(0.0, s);
    }
    while (!queue.empty()) {
        const auto [d, v] = queue.top();
        queue.pop();
        if (d > out.distance[v]) continue;
        if (stop(v)) return v;
        for (std::uint32_t a = graph_.first[v]; a < graph_.first[v + 1]; ++a) {
            const auto& arc = graph_.arcs[a];
            if (!closed.empty() && (closed[arc.to] || cut_[arc.half_edge])) continue;
            if (d + arc.cost < out.distance[arc.to]) {
                out.distance[arc.to] = d + arc.cost;
                out.arc[arc.to] = a;
                queue.emplace(d + arc.cost, arc.to);
            }
        }
    }
    return kNone;
}

void CutGraph::mark(std::uint32_t half_edge, bool cut) {
    if (opposite_[half_edge] == kNone) return;
    cut_[half_edge] = cut_[opposite_[half_edge]] = cut;
}

void CutGraph::mark_path(const Search& found, std::uint32_t from) {
    for (std::uint32_t v = from; found.arc[v] != kNone;) {
        const std::uint32_t h = graph_.arcs[found.arc[v]].half_edge;
        mark(h, true);
        v = origin(mesh_->faces, h) == v ? target(mesh_->faces, h) : origin(mesh_->faces, h);
    }
}

std::vector<std::uint32_t> CutGraph::cut_vertices() const {
    std::vector<char> on(mesh_->positions.size(), 0);
    for (std::uint32_t h = 0; h < opposite_.size(); ++h)
        if (cut_[h] || opposite_[h] == kNone) on[origin(mesh_->faces, h)] = on[target(mesh_->faces, h)] = 1;
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t v = 0; v < on.size(); ++v)
        if (on[v]) vertices.push_back(v);
    return vertices;
}

void CutGraph::cut_to_disk(std::uint32_t root, CutStart start) {
    if (genus_ > 0) {
        cut_handles(root);  // joins the borders as well
        shorten();
    } else if (!loops_.empty()) {
        join_boundary_loops();
        shorten();
    } else {
        mark_first_path(start);
    }
}

std::uint32_t CutGraph::farthest(std::uint32_t from, Search& out) const {
    search(
        std::span(&from, 1), [](std::uint32_t) { return false; }, out);
    return place_of_largest(out.distance);
}

double CutGraph::longest_way() const {
    Search s;
    return s.distance[farthest(farthest(outermost(mesh_->positions), s), s)];
}

void CutGraph::mark_first_path(CutStart start) {
    Search s;
    mark_path(s, farthest(farthest(outermost(mesh_->positions), s), s));
    if (start == CutStart::kLong) return;
    const std::uint32_t aside = place_of_largest(distance_to_cut());
    std::fill(cut_.begin(), cut_.end(), 0);
    std::uint32_t end = farthest(aside, s);
    if (start == CutStart::kShort) {
        std::vector<std::uint32_t> nearest(s.distance.size());
        std::iota(nearest.begin(), nearest.end(), 0u);
        const auto half = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
        std::nth_element(nearest.begin(), half, nearest.end(), [&](std::uint32_t a, std::uint32_t b) {
            return std::pair(s.distance[a], a) < std::pair(s.distance[b], b);
        });
        end = *half;
    }
    mark_path(s, end);
}

std::uint32_t CutGraph::middle() const {
    const std::size_t n = mesh_->positions.size();
    // The vertex nearest to the middle of the surface keeps the loops short on both sides.
    Search tree;
    std::uint32_t root = outermost(mesh_->positions);
    for (int sweep = 0; sweep < 2; ++sweep) root = farthest(root, tree);
    Search other = tree;  // distances from one end; now from the far end, then take a vertex between
    search(
        std::span(&root, 1), [](std::uint32_t) { return false; }, tree);
    double best = kInfinity;
    for (std::uint32_t v = 0; v < n; ++v) {
        const double worse = std::max(tree.distance[v], other.distance[v]);
        if (worse < best) {
            best = worse;
            root = v;
        }
    }
    return root;
}

void CutGraph::cut_handles(std::uint32_t root) {
    const std::size_t n = mesh_->positions.size();
    if (root == kNone) root = middle();
    Search tree;
    search(
        std::span(&root, 1), [](std::uint32_t) { return false; }, tree);

    std::vector<char> in_tree(opposite_.size(), 0);
    for (std::uint32_t v = 0; v < n; ++v)
        if (tree.arc[v] != kNone) {
            const std::uint32_t h = graph_.arcs[tree.arc[v]].half_edge;
            in_tree[h] = 1;
            if (opposite_[h] != kNone) in_tree[opposite_[h]] = 1;
        }
    // A spanning tree of the faces opens the surface into a tree of triangles, which is a disk whatever the genus and
    // the borders. Edges whose loop over the root is longest are crossed first, edges of the tree of shortest paths
    // only where nothing else joins the faces (a path from border to border parts them).
    struct Edge {
        bool on_path;
        double loop;
        std::uint32_t half_edge;
    };
    std::vector<Edge> edges;
    for (std::uint32_t h = 0; h < opposite_.size(); ++h) {
        if (opposite_[h] == kNone || opposite_[h] < h) continue;
        const std::uint32_t a = origin(mesh_->faces, h), b = target(mesh_->faces, h);
        edges.push_back({in_tree[h] != 0, tree.distance[a] + tree.distance[b] + edge_cost(h), h});
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
        if (x.on_path != y.on_path) return y.on_path;
        return x.loop != y.loop ? x.loop > y.loop : x.half_edge < y.half_edge;
    });
    UnionFind faces(mesh_->faces.size());
    for (const Edge& e : edges)
        if (!faces.unite(e.half_edge / 3, opposite_[e.half_edge] / 3)) mark(e.half_edge, true);
    prune();
}

void CutGraph::join_boundary_loops() {
    std::vector<std::uint32_t> loop_of(mesh_->positions.size(), kNone);
    std::vector<std::vector<std::uint32_t>> members(loops_.size());
    for (std::uint32_t k = 0; k < loops_.size(); ++k) {
        std::uint32_t h = loops_[k];
        do {
            loop_of[origin(mesh_->faces, h)] = k;
            members[k].push_back(origin(mesh_->faces, h));
            h = next_border_half_edge(opposite_, h);
        } while (h != loops_[k]);
    }
    std::vector<char> joined(loops_.size(), 0), on(mesh_->positions.size(), 0);
    std::vector<std::uint32_t> sources;
    const auto add_vertex = [&](std::uint32_t v) {
        if (!on[v]) {
            on[v] = 1;
            sources.push_back(v);
        }
    };
    std::size_t open = loops_.size();
    const auto add_loop = [&](std::uint32_t k) {
        joined[k] = 1;
        --open;
        for (std::uint32_t v : members[k]) add_vertex(v);
    };
    // Start from the longest loop: it is the one that should face the square's border most.
    std::size_t longest = 0;
    for (std::size_t k = 1; k < members.size(); ++k)
        if (members[k].size() > members[longest].size()) longest = k;
    add_loop(static_cast<std::uint32_t>(longest));
    Search s;
    while (open > 0) {
        const std::uint32_t end = search(
            sources, [&](std::uint32_t v) { return loop_of[v] != kNone && !joined[loop_of[v]]; }, s);
        if (end == kNone) break;  // cannot happen on a connected component
        for (std::uint32_t v = end; s.arc[v] != kNone;) {
            const std::uint32_t h = graph_.arcs[s.arc[v]].half_edge;
            mark(h, true);
            v = origin(mesh_->faces, h) == v ? target(mesh_->faces, h) : origin(mesh_->faces, h);
            add_vertex(v);
        }
        add_loop(loop_of[end]);
    }
}

std::vector<std::uint32_t> CutGraph::cut_degrees() const {
    std::vector<std::uint32_t> degree(mesh_->positions.size(), 0);
    for (std::uint32_t h = 0; h < cut_.size(); ++h)
        if (cut_[h] && h < opposite_[h]) {
            ++degree[origin(mesh_->faces, h)];
            ++degree[target(mesh_->faces, h)];
        }
    return degree;
}

std::vector<char> CutGraph::tips() const {
    const std::vector<std::uint32_t> degree = cut_degrees();
    std::vector<char> out(degree.size(), 0);
    for (std::size_t v = 0; v < out.size(); ++v) out[v] = degree[v] == 1;
    for (std::uint32_t h = 0; h < opposite_.size(); ++h)
        if (opposite_[h] == kNone) out[origin(mesh_->faces, h)] = 0;
    return out;
}

void CutGraph::prune() {
    std::vector<std::uint32_t> degree = cut_degrees();
    std::vector<char> border(degree.size(), 0);
    for (std::uint32_t h = 0; h < opposite_.size(); ++h)
        if (opposite_[h] == kNone) border[origin(mesh_->faces, h)] = 1;
    std::vector<std::uint32_t> leaves;
    const auto is_leaf = [&](std::uint32_t v) { return degree[v] == 1 && !border[v]; };
    for (std::uint32_t v = 0; v < degree.size(); ++v)
        if (is_leaf(v)) leaves.push_back(v);
    while (!leaves.empty()) {
        const std::uint32_t v = leaves.back();
        leaves.pop_back();
        if (!is_leaf(v)) continue;
        for (std::uint32_t a = graph_.first[v]; a < graph_.first[v + 1]; ++a) {
            const auto& arc = graph_.arcs[a];
            if (!cut_[arc.half_edge]) continue;
            mark(arc.half_edge, false);
            --degree[v];
            --degree[arc.to];
            if (is_leaf(arc.to)) leaves.push_back(arc.to);
        }
    }
}

void CutGraph::weigh(std::span<const double> factors) {
    factors_.assign(factors.begin(), factors.end());
    for (VertexGraph::Arc& arc : graph_.arcs) arc.cost = edge_cost(arc.half_edge);
}

double CutGraph::edge_cost(std::uint32_t half_edge) const {
    return factor(half_edge) * dgm::model::length(mesh_->positions[origin(mesh_->faces, half_edge)] -
                                                  mesh_->positions[target(mesh_->faces, half_edge)]);
}

double CutGraph::connect(std::uint32_t from, std::uint32_t to) {
    std::vector<char> closed(mesh_->positions.size(), 0);
    for (std::uint32_t v : cut_vertices()) closed[v] = 1;
    closed[to] = 0;
    Search s;
    const std::uint32_t end = search(
        std::span(&from, 1), [&](std::uint32_t v) { return v == to; }, s, closed);
    if (end == kNone || end == from) return kInfinity;
    mark_path(s, end);
    return s.distance[end];
}

double CutGraph::join(std::uint32_t vertex) {
    std::vector<char> on(mesh_->positions.size(), 0);
    for (std::uint32_t v : cut_vertices()) on[v] = 1;
    Search s;
    const std::uint32_t end = search(
        std::span(&vertex, 1), [&](std::uint32_t v) { return on[v] != 0; }, s);
    if (end == kNone || end == vertex) return 0;
    mark_path(s, end);
    return s.distance[end];
}

std::vector<double> CutGraph::distance_to_cut() const {
    std::vector<double> distance(mesh_->positions.size(), kInfinity);
    follow_cut(distance);
    return distance;
}

void CutGraph::follow_cut(std::vector<double>& distance) const {
    DistanceQueue queue;
    for (const std::uint32_t v : cut_vertices()) {
        if (!(distance[v] > 0)) continue;
        distance[v] = 0;
        queue.emplace(0.0, v);
    }
    spread(graph_, queue, distance);
}

double CutGraph::length() const {
    double total = 0;
    for (std::uint32_t h = 0; h < cut_.size(); ++h)
        if (cut_[h] && h < opposite_[h])
            total += dgm::model::length(mesh_->positions[origin(mesh_->faces, h)] -
                                        mesh_->positions[target(mesh_->faces, h)]);
    return total;
}

// Connected, and of Euler characteristic 1.
bool CutGraph::opens_to_disk() const {
    const std::span<const Face> faces = mesh_->faces;
    UnionFind joined(faces.size());
    std::size_t parts = faces.size();
    std::int64_t edges = 0, vertices = 0;
    std::vector<char> inside(mesh_->positions.size(), 0);
    for (std::uint32_t h = 0; h < opposite_.size(); ++h) inside[origin(faces, h)] = 1;
    for (std::uint32_t h = 0; h < opposite_.size(); ++h) {
        const std::uint32_t across = opposite_[h];
        if (across == kNone || cut_[h]) {
            inside[origin(faces, h)] = inside[target(faces, h)] = 0;
        } else if (h < across) {
            ++edges;
            if (joined.unite(h / 3, across / 3)) --parts;
        }
    }
    for (const char v : inside) vertices += v;
    return parts == 1 && vertices - edges + static_cast<std::int64_t>(faces.size()) == 1;
}

Disk CutGraph::open() const {
    Disk disk;
    disk.mesh = *mesh_;
    disk.mesh.positions.clear();
    disk.mesh.points.clear();
    disk.opposite = opposite_;
    disk.mate.assign(opposite_.size(), kNone);
    UnionFind corners(opposite_.size());
    for (std::uint32_t h = 0; h < opposite_.size(); ++h) {
        const std::uint32_t o = opposite_[h];
        if (o == kNone) continue;
        if (cut_[h]) {
            disk.opposite[h] = kNone;
            disk.mate[h] = o;
        } else if (h < o) {
            corners.unite(h, next_half_edge(o));
            corners.unite(next_half_edge(h), o);
        }
    }
    std::vector<std::uint32_t> id(opposite_.size(), kNone);
    for (std::uint32_t c = 0; c < opposite_.size(); ++c) {
        const std::uint32_t set = corners.find(c), v = mesh_->faces[c / 3][c % 3];
        if (id[set] == kNone) {
            id[set] = static_cast<std::uint32_t>(disk.mesh.positions.size());
            disk.mesh.positions.push_back(mesh_->positions[v]);
            disk.weld.push_back(v);
            if (!mesh_->points.empty()) disk.mesh.points.push_back(mesh_->points[v]);
        }
        disk.mesh.faces[c / 3][c % 3] = id[set];
    }
    disk.weld_count = static_cast<std::uint32_t>(mesh_->positions.size());
    return disk;
}

}  // namespace dgm::bake
