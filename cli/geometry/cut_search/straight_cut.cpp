// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/straight_cut.cpp
#include "geometry/cut_search/straight_cut.h"

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <queue>
#include <unordered_map>
#include <vector>

#include "geometry/mesh/infinity.h"

namespace dgm::bake {
namespace {

constexpr std::uint32_t kPlaces = 3;  // on an edge, where a path may cross it
constexpr double kNearest = 0.1;      // to an end of its edge, in edges: nearer crossings leave slivers
constexpr int kSweeps = 60;
constexpr int kTries = 24;  // maps from paths to surfaces, to find out which paths had better stay

/// A vertex, or a place on an edge; half-edges of places run along the face on the path's far side.
struct Place {
    std::uint32_t vertex = kNone, half_edge = kNone;
    double at = 0;  ///< from the half-edge's origin to its target
};

/// The piece of the cut between two nodes; a loop has two, which meet at its middle.
struct Piece {
    std::vector<std::uint32_t> edges_way;  ///< vertices
    double reach;
};

class Straightener {
 public:
    Straightener(const CutGraph& cut, double reach) : cut_(cut), mesh_(cut.mesh()), across_(cut.opposite()) {
        const Disk disk = cut.open();
        const std::vector<BorderPath> paths = disk.paths();
        for (std::size_t p = 0; p < paths.size(); ++p) {
            const BorderPath& path = paths[p];
            if (path.mate == kNone || path.mate < p) continue;
            std::vector<std::uint32_t> way;
            for (const std::uint32_t h : path.half_edges) way.push_back(disk.weld[origin(disk.mesh.faces, h)]);
            way.push_back(disk.weld[target(disk.mesh.faces, path.half_edges.back())]);
            const double step = reach * path.length / static_cast<double>(path.half_edges.size());
            if (!path.is_loop) {
                pieces_.push_back({std::move(way), step});
                continue;
            }
            const auto middle = way.begin() + static_cast<std::ptrdiff_t>(way.size() / 2);
            pieces_.push_back({{way.begin(), middle + 1}, step});
            pieces_.push_back({{middle, way.end()}, step});
        }
    }

    Disk run() {
        std::vector<char> chosen(pieces_.size(), 1);
        if (std::optional<Disk> disk = opened(chosen)) return std::move(*disk);
        std::fill(chosen.begin(), chosen.end(), 0);
        choose(chosen, 0, pieces_.size());
        std::optional<Disk> disk = opened(chosen);
        return disk ? std::move(*disk) : cut_.open();
    }

 private:
    /// Adds to `chosen` those of pieces [first, last) that can be straight, as far as kTries reach.
    void choose(std::vector<char>& chosen, std::size_t first, std::size_t last) {
        if (last - first == 1) return;
        const std::size_t middle = first + (last - first) / 2;
        for (const auto& [from, to] : {std::pair{first, middle}, std::pair{middle, last}}) {
            if (++tries_ > kTries) return;
            std::fill(chosen.begin() + static_cast<std::ptrdiff_t>(from),
                      chosen.begin() + static_cast<std::ptrdiff_t>(to), 1);
            if (opened(chosen)) continue;
            std::fill(chosen.begin() + static_cast<std::ptrdiff_t>(from),
                      chosen.begin() + static_cast<std::ptrdiff_t>(to), 0);
            choose(chosen, from, to);
        }
    }

    /// The surface opened with the chosen pieces straight; nothing if that is no disk.
    std::optional<Disk> opened(const std::vector<char>& chosen) {
        reset();
        std::vector<std::vector<Place>> ways(pieces_.size());
        for (std::size_t k = 0; k < pieces_.size(); ++k)
            if (chosen[k]) ways[k] = straightened(pieces_[k]);
        TriMesh mesh = mesh_;
        std::vector<std::uint32_t> across(across_.begin(), across_.end());
        std::vector<std::vector<std::uint32_t>> vertices(pieces_.size());
        for (std::size_t k = 0; k < pieces_.size(); ++k) {
            if (ways[k].empty()) vertices[k] = pieces_[k].edges_way;
            for (const Place& p : ways[k])
                vertices[k].push_back(p.vertex != kNone ? p.vertex
                                                        : split_edge(mesh, across, p.half_edge, p.at).vertex);
        }
        CutGraph straight(mesh);
        const VertexGraph& graph = straight.graph();
        for (const std::vector<std::uint32_t>& way : vertices)
            for (std::size_t k = 0; k + 1 < way.size(); ++k)
                for (std::uint32_t a = graph.first[way[k]]; a < graph.first[way[k] + 1]; ++a)
                    if (graph.arcs[a].to == way[k + 1]) straight.mark(graph.arcs[a].half_edge, true);
        if (!straight.opens_to_disk()) return std::nullopt;
        return straight.open();
    }

    void reset() {
        used_.assign(mesh_.positions.size(), 0);
        taken_.assign(mesh_.faces.size(), 0);
        closed_.assign(across_.size(), 0);
        for (std::uint32_t h = 0; h < across_.size(); ++h) {
            closed_[h] = across_[h] == kNone || cut_.is_cut(h);
            if (closed_[h]) used_[origin(mesh_.faces, h)] = used_[target(mesh_.faces, h)] = 1;
        }
        near_.assign(mesh_.positions.size(), 0);
    }

    /// Closes or opens the edges of a way, and its vertices but the ends.
    void close(const std::vector<std::uint32_t>& way, char closed) {
        const VertexGraph& graph = cut_.graph();
        for (std::size_t k = 0; k + 1 < way.size(); ++k) {
            if (k > 0) used_[way[k]] = closed;
            for (std::uint32_t a = graph.first[way[k]]; a < graph.first[way[k] + 1]; ++a) {
                const std::uint32_t h = graph.arcs[a].half_edge;
                if (graph.arcs[a].to == way[k + 1] && across_[h] != kNone) closed_[h] = closed_[across_[h]] = closed;
            }
        }
    }

    /// Where a piece runs now, and everything on it closed to the others; empty if it stays as it was.
    std::vector<Place> straightened(const Piece& piece) {
        const std::vector<std::uint32_t>& old = piece.edges_way;
        close(old, 0);
        const std::vector<std::uint32_t> ball = surroundings(old, piece.reach);
        for (const std::uint32_t v : ball) near_[v] = 1;
        std::vector<Place> way = shortest(old.front(), old.back());
        for (const std::uint32_t v : ball) near_[v] = 0;
        if (!way.empty()) relax(way);
        if (way.empty() || !(cost_of(way) < cost_of(old)) || !take(way)) {
            close(old, 1);
            return {};
        }
        return way;
    }

    /// Vertices within `reach` of a way, by edges.
    std::vector<std::uint32_t> surroundings(const std::vector<std::uint32_t>& way, double reach) {
        std::unordered_map<std::uint32_t, double> distance;
        using Entry = std::pair<double, std::uint32_t>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
        for (const std::uint32_t v : way) distance[v] = 0, queue.emplace(0.0, v);
        const VertexGraph& graph = cut_.graph();
        std::vector<std::uint32_t> out;
        while (!queue.empty()) {
            const auto [d, v] = queue.top();
            queue.pop();
            if (d > distance[v]) continue;
            out.push_back(v);
            for (std::uint32_t a = graph.first[v]; a < graph.first[v + 1]; ++a) {
                const double next = d + graph.arcs[a].length;
                if (next > reach) continue;
                const auto [it, fresh] = distance.try_emplace(graph.arcs[a].to, kInfinity);
                if (next < it->second) it->second = next, queue.emplace(next, it->first);
            }
        }
        return out;
    }

    // Nodes of the search: vertices first, then kPlaces for each half-edge that is the lower of its two.
    [[nodiscard]] std::uint64_t node(std::uint32_t h, std::uint32_t place) const {
        const bool lower = h < across_[h];
        return mesh_.positions.size() + std::uint64_t{lower ? h : across_[h]} * kPlaces +
               (lower ? place : kPlaces - 1 - place);
    }
    [[nodiscard]] Place place_of(std::uint64_t node) const {
        if (node < mesh_.positions.size()) return {static_cast<std::uint32_t>(node), kNone, 0};
        const std::uint64_t k = node - mesh_.positions.size();
        return {kNone, static_cast<std::uint32_t>(k / kPlaces),
                (1.0 + static_cast<double>(k % kPlaces)) / (kPlaces + 1)};
    }
    [[nodiscard]] Vec3d position(const Place& p) const {
        if (p.vertex != kNone) return mesh_.positions[p.vertex];
        return mesh_.positions[origin(mesh_.faces, p.half_edge)] * (1 - p.at) +
               mesh_.positions[target(mesh_.faces, p.half_edge)] * p.at;
    }

    /// The shortest way near a path, over free vertices and across open edges of free faces; empty if there is none.
    std::vector<Place> shortest(std::uint32_t from, std::uint32_t to) {
        struct State {
            double distance;
            std::uint64_t before;
        };
        std::unordered_map<std::uint64_t, State> reached;
        using Entry = std::pair<double, std::uint64_t>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
        const auto reach = [&](std::uint64_t node, double distance, std::uint64_t before) {
            const auto [it, fresh] = reached.try_emplace(node, State{kInfinity, 0});
            if (!(distance < it->second.distance)) return;
            it->second = {distance, before};
            queue.emplace(distance, node);
        };
        const auto enter = [&](std::uint32_t v) { return v == to || (near_[v] && !used_[v]); };
        reach(from, 0, from);
        while (!queue.empty() && queue.top().second != to) {
            const auto [d, at] = queue.top();
            queue.pop();
            if (d > reached[at].distance) continue;
            const Place here = place_of(at);
            const Vec3d p = position(here);
            const auto cross = [&, d = d, at = at](std::uint32_t h) {
                if (closed_[h] || taken_[across_[h] / 3]) return;
                const double weight = weight_of(h / 3);
                const std::uint32_t a = origin(mesh_.faces, h), b = target(mesh_.faces, h);
                if (!near_[a] && !near_[b]) return;
                for (std::uint32_t k = 0; k < kPlaces; ++k) {
                    const Vec3d q = position({kNone, h, (1.0 + k) / (kPlaces + 1)});
                    reach(node(h, k), d + weight * length(q - p), at);
                }
            };
            if (here.vertex != kNone) {
                const VertexGraph& graph = cut_.graph();
                for (std::uint32_t a = graph.first[here.vertex]; a < graph.first[here.vertex + 1]; ++a) {
                    const VertexGraph::Arc& arc = graph.arcs[a];
                    if (across_[arc.half_edge] == kNone) continue;
                    if (!closed_[arc.half_edge] && enter(arc.to)) reach(arc.to, d + arc.cost, at);
                }
                for (std::uint32_t a = graph.first[here.vertex]; a < graph.first[here.vertex + 1]; ++a) {
                    std::uint32_t h = graph.arcs[a].half_edge;
                    if (origin(mesh_.faces, h) != here.vertex) h = across_[h];
                    if (h != kNone && !taken_[h / 3]) cross(next_half_edge(h));
                }
                continue;
            }
            for (const std::uint32_t h : {here.half_edge, across_[here.half_edge]}) {
                if (taken_[h / 3]) continue;
                const std::uint32_t apex = target(mesh_.faces, next_half_edge(h));
                if (enter(apex)) reach(apex, d + weight_of(h / 3) * length(mesh_.positions[apex] - p), at);
                cross(next_half_edge(h));
                cross(previous_half_edge(h));
            }
        }
        std::vector<Place> way;
        if (queue.empty()) return way;
        for (std::uint64_t at = to;; at = reached[at].before) {
            way.push_back(place_of(at));
            if (at == from) break;
        }
        std::reverse(way.begin(), way.end());
        return way;
    }

    /// Slides each crossing along its edge to where the way is shortest between its neighbours, again and again.
    void relax(std::vector<Place>& way) const {
        for (int sweep = 0; sweep < kSweeps; ++sweep)
            for (std::size_t k = 1; k + 1 < way.size(); ++k) {
                if (way[k].vertex != kNone) continue;
                const Vec3d a = mesh_.positions[origin(mesh_.faces, way[k].half_edge)],
                            b = mesh_.positions[target(mesh_.faces, way[k].half_edge)];
                const Vec3d before = position(way[k - 1]) - a, after = position(way[k + 1]) - a;
                const double edge = length(b - a);
                if (!(edge > 0)) continue;
                // Unfolded about the edge, the straight line between the neighbours meets it there.
                const Vec3d along = (b - a) / edge;
                const double x = dot(before, along), y = dot(after, along);
                const double high = length(before - along * x), low = length(after - along * y);
                if (high + low > 0)
                    way[k].at = std::clamp((x * low + y * high) / (high + low) / edge, kNearest, 1 - kNearest);
            }
    }

    [[nodiscard]] double edge_cost(std::uint32_t a, std::uint32_t b) const {
        const VertexGraph& graph = cut_.graph();
        for (std::uint32_t k = graph.first[a]; k < graph.first[a + 1]; ++k)
            if (graph.arcs[k].to == b) return graph.arcs[k].cost;
        return kInfinity;
    }
    [[nodiscard]] double cost_of(const std::vector<std::uint32_t>& way) const {
        double sum = 0;
        for (std::size_t k = 0; k + 1 < way.size(); ++k) sum += edge_cost(way[k], way[k + 1]);
        return sum;
    }
    [[nodiscard]] double cost_of(const std::vector<Place>& way) const {
        double sum = 0;
        for (std::size_t k = 0; k + 1 < way.size(); ++k) {
            const std::uint32_t face = face_between(way[k], way[k + 1]);
            sum += face == kNone ? edge_cost(way[k].vertex, way[k + 1].vertex)
                                 : weight_of(face) * length(position(way[k + 1]) - position(way[k]));
        }
        return sum;
    }

    /// What a way through a face costs, in lengths: as much as its edges do.
    [[nodiscard]] double weight_of(std::uint32_t face) const {
        double sum = 0;
        for (std::uint32_t h = 3 * face; h < 3 * face + 3; ++h) sum += cut_.factor(h);
        return sum / 3;
    }

    /// Closes a way to the others, and names its crossings by the half-edges beyond them: splitting one leaves those of
    /// the others as they are. False, and nothing done, if it passes a face twice.
    bool take(std::vector<Place>& way) {
        std::vector<std::uint32_t> faces, vertices;
        for (std::size_t k = 0; k + 1 < way.size(); ++k) {
            const std::uint32_t face = face_between(way[k], way[k + 1]);
            if (face == kNone) continue;
            faces.push_back(face);
            Place& next = way[k + 1];
            if (next.vertex == kNone && next.half_edge / 3 == face)
                next.half_edge = across_[next.half_edge], next.at = 1 - next.at;
        }
        std::vector<std::uint32_t> sorted = faces;
        std::sort(sorted.begin(), sorted.end());
        if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return false;
        for (const std::uint32_t f : faces) taken_[f] = 1;
        for (std::size_t k = 0; k < way.size(); ++k) {
            if (way[k].vertex == kNone)
                closed_[way[k].half_edge] = closed_[across_[way[k].half_edge]] = 1;
            else
                used_[way[k].vertex] = 1;
            if (k > 0 && way[k].vertex != kNone && way[k - 1].vertex != kNone)
                close({way[k - 1].vertex, way[k].vertex}, 1);
        }
        return true;
    }

    /// The face that two places in a row have in common; kNone if the way runs along an edge there.
    [[nodiscard]] std::uint32_t face_between(const Place& a, const Place& b) const {
        if (a.vertex != kNone && b.vertex != kNone) return kNone;
        const Place& on_edge = a.vertex == kNone ? a : b;
        const Place& other = a.vertex == kNone ? b : a;
        for (const std::uint32_t h : {on_edge.half_edge, across_[on_edge.half_edge]}) {
            if (other.vertex != kNone ? target(mesh_.faces, next_half_edge(h)) == other.vertex
                                      : h / 3 == other.half_edge / 3 || h / 3 == across_[other.half_edge] / 3)
                return h / 3;
        }
        return kNone;
    }

    const CutGraph& cut_;
    const TriMesh& mesh_;
    std::span<const std::uint32_t> across_;
    std::vector<Piece> pieces_;
    std::vector<char> used_;    // per vertex: on a path or on the border
    std::vector<char> taken_;   // per face: a path runs through it
    std::vector<char> closed_;  // per half-edge: on the border, or a path runs along it or across it
    std::vector<char> near_;    // per vertex: within reach of the piece at hand
    int tries_ = 0;
};

}  // namespace

Disk open_straight(const CutGraph& cut, double reach) {
    return Straightener(cut, reach).run();
}

}  // namespace dgm::bake
