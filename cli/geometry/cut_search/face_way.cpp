// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/face_way.cpp
#include "geometry/cut_search/face_way.h"

#include <algorithm>
#include <array>
#include <functional>
#include <queue>
#include <unordered_map>
#include <utility>

#include "geometry/mesh/infinity.h"

namespace dgm::bake {
namespace {

constexpr std::uint32_t kPlaces = 3;  // on an edge, where a way may cross it
constexpr double kNearest = 0.1;      // to an end of its edge, in edges: nearer crossings leave slivers
constexpr int kSweeps = 60;

/// Cost of a way through a face, in lengths.
double face_factor(const CutGraph& cut, std::uint32_t face) {
    double sum = 0;
    for (std::uint32_t h = 3 * face; h < 3 * face + 3; ++h) sum += cut.factor(h);
    return sum / 3;
}

double edge_cost(const CutGraph& cut, std::uint32_t a, std::uint32_t b) {
    const VertexGraph& graph = cut.graph();
    for (std::uint32_t k = graph.first[a]; k < graph.first[a + 1]; ++k)
        if (graph.arcs[k].to == b) return graph.arcs[k].cost;
    return kInfinity;
}

/// Shortest ways [Dijkstra 1959] over a graph whose nodes are the vertices first, then kPlaces for each half-edge that
/// is the lower of its two.
class WaySearch {
 public:
    WaySearch(const CutGraph& cut, const Occupied& occupied, std::span<const char> near, std::uint32_t to)
        : cut_(cut), mesh_(cut.mesh()), across_(cut.opposite()), occupied_(occupied), near_(near), to_(to) {}

    std::vector<Place> from(std::uint32_t start) {
        reach(start, 0, start);
        while (!queue_.empty() && queue_.top().second != to_) {
            const auto [distance, node] = queue_.top();
            queue_.pop();
            if (distance > reached_[node].distance) continue;
            const Place place = place_of(node);
            const Here here{node, distance, position_at(mesh_, place)};
            if (place.vertex != kNone)
                leave_vertex(here, place.vertex);
            else
                leave_edge(here, place.half_edge);
        }
        return queue_.empty() ? std::vector<Place>{} : trace(start);
    }

 private:
    struct State {
        double distance;
        std::uint64_t before;
    };
    struct Here {
        std::uint64_t node;
        double distance;
        Vec3d position;
    };

    [[nodiscard]] std::uint64_t node_of(std::uint32_t h, std::uint32_t place) const {
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

    void reach(std::uint64_t node, double distance, std::uint64_t before) {
        const auto [it, fresh] = reached_.try_emplace(node, State{kInfinity, 0});
        if (!(distance < it->second.distance)) return;
        it->second = {distance, before};
        queue_.emplace(distance, node);
    }

    [[nodiscard]] bool may_enter(std::uint32_t v) const { return v == to_ || (near_[v] && !occupied_.vertex(v)); }

    void leave_vertex(const Here& here, std::uint32_t v) {
        const VertexGraph& graph = cut_.graph();
        for (std::uint32_t a = graph.first[v]; a < graph.first[v + 1]; ++a) {
            const VertexGraph::Arc& arc = graph.arcs[a];
            if (across_[arc.half_edge] == kNone) continue;
            if (!occupied_.half_edge(arc.half_edge) && may_enter(arc.to))
                reach(arc.to, here.distance + arc.cost, here.node);
        }
        for (std::uint32_t a = graph.first[v]; a < graph.first[v + 1]; ++a) {
            std::uint32_t h = graph.arcs[a].half_edge;
            if (origin(mesh_.faces, h) != v) h = across_[h];
            if (h != kNone && !occupied_.face(h / 3)) cross_to(here, next_half_edge(h));
        }
    }

    void leave_edge(const Here& here, std::uint32_t half_edge) {
        for (const std::uint32_t h : {half_edge, across_[half_edge]}) {
            if (occupied_.face(h / 3)) continue;
            const std::uint32_t apex = target(mesh_.faces, next_half_edge(h));
            if (may_enter(apex)) {
                const double along = length(mesh_.positions[apex] - here.position);
                reach(apex, here.distance + face_factor(cut_, h / 3) * along, here.node);
            }
            cross_to(here, next_half_edge(h));
            cross_to(here, previous_half_edge(h));
        }
    }

    /// Goes through the face of `h` to the places on its edge.
    void cross_to(const Here& here, std::uint32_t h) {
        if (occupied_.half_edge(h) || occupied_.face(across_[h] / 3)) return;
        if (!near_[origin(mesh_.faces, h)] && !near_[target(mesh_.faces, h)]) return;
        const double factor = face_factor(cut_, h / 3);
        for (std::uint32_t k = 0; k < kPlaces; ++k) {
            const Vec3d q = position_at(mesh_, Place{kNone, h, (1.0 + k) / (kPlaces + 1)});
            reach(node_of(h, k), here.distance + factor * length(q - here.position), here.node);
        }
    }

    [[nodiscard]] std::vector<Place> trace(std::uint32_t start) {
        std::vector<Place> way;
        for (std::uint64_t at = to_;; at = reached_[at].before) {
            way.push_back(place_of(at));
            if (at == start) break;
        }
        std::reverse(way.begin(), way.end());
        return way;
    }

    using Entry = std::pair<double, std::uint64_t>;

    const CutGraph& cut_;
    const TriMesh& mesh_;
    std::span<const std::uint32_t> across_;
    const Occupied& occupied_;
    std::span<const char> near_;
    std::uint32_t to_;
    std::unordered_map<std::uint64_t, State> reached_;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

}  // namespace

Vec3d position_at(const TriMesh& mesh, const Place& place) {
    if (place.vertex != kNone) return mesh.positions[place.vertex];
    return mesh.positions[origin(mesh.faces, place.half_edge)] * (1 - place.at) +
           mesh.positions[target(mesh.faces, place.half_edge)] * place.at;
}

std::uint32_t face_between(const CutGraph& cut, const Place& a, const Place& b) {
    if (a.vertex != kNone && b.vertex != kNone) return kNone;
    const std::span<const std::uint32_t> across = cut.opposite();
    const std::vector<Face>& faces = cut.mesh().faces;
    const Place& on_edge = a.vertex == kNone ? a : b;
    const Place& other = a.vertex == kNone ? b : a;
    for (const std::uint32_t h : {on_edge.half_edge, across[on_edge.half_edge]}) {
        if (other.vertex != kNone ? target(faces, next_half_edge(h)) == other.vertex
                                  : h / 3 == other.half_edge / 3 || h / 3 == across[other.half_edge] / 3)
            return h / 3;
    }
    return kNone;
}

double way_cost(const CutGraph& cut, std::span<const std::uint32_t> vertices) {
    double sum = 0;
    for (std::size_t k = 0; k + 1 < vertices.size(); ++k) sum += edge_cost(cut, vertices[k], vertices[k + 1]);
    return sum;
}

double way_cost(const CutGraph& cut, std::span<const Place> way) {
    const TriMesh& mesh = cut.mesh();
    double sum = 0;
    for (std::size_t k = 0; k + 1 < way.size(); ++k) {
        const std::uint32_t face = face_between(cut, way[k], way[k + 1]);
        sum += face == kNone
                   ? edge_cost(cut, way[k].vertex, way[k + 1].vertex)
                   : face_factor(cut, face) * length(position_at(mesh, way[k + 1]) - position_at(mesh, way[k]));
    }
    return sum;
}

void relax_way(const TriMesh& mesh, std::span<Place> way) {
    for (int sweep = 0; sweep < kSweeps; ++sweep)
        for (std::size_t k = 1; k + 1 < way.size(); ++k) {
            if (way[k].vertex != kNone) continue;
            const Vec3d a = mesh.positions[origin(mesh.faces, way[k].half_edge)],
                        b = mesh.positions[target(mesh.faces, way[k].half_edge)];
            const Vec3d before = position_at(mesh, way[k - 1]) - a, after = position_at(mesh, way[k + 1]) - a;
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

Occupied::Occupied(const CutGraph& cut)
    : cut_(cut),
      vertices_(cut.mesh().positions.size(), 0),
      faces_(cut.mesh().faces.size(), 0),
      half_edges_(cut.opposite().size(), 0) {
    const std::vector<Face>& faces = cut.mesh().faces;
    for (std::uint32_t h = 0; h < half_edges_.size(); ++h) {
        half_edges_[h] = cut.opposite()[h] == kNone || cut.is_cut(h);
        if (half_edges_[h]) vertices_[origin(faces, h)] = vertices_[target(faces, h)] = 1;
    }
}

void Occupied::set_edges(std::span<const std::uint32_t> vertices, bool occupied) {
    const VertexGraph& graph = cut_.graph();
    const std::span<const std::uint32_t> across = cut_.opposite();
    for (std::size_t k = 0; k + 1 < vertices.size(); ++k) {
        if (k > 0) vertices_[vertices[k]] = occupied;
        for (std::uint32_t a = graph.first[vertices[k]]; a < graph.first[vertices[k] + 1]; ++a) {
            const std::uint32_t h = graph.arcs[a].half_edge;
            if (graph.arcs[a].to == vertices[k + 1] && across[h] != kNone)
                half_edges_[h] = half_edges_[across[h]] = occupied;
        }
    }
}

bool Occupied::add(std::span<Place> way) {
    const std::span<const std::uint32_t> across = cut_.opposite();
    std::vector<std::uint32_t> faces;
    for (std::size_t k = 0; k + 1 < way.size(); ++k) {
        const std::uint32_t face = face_between(cut_, way[k], way[k + 1]);
        if (face == kNone) continue;
        faces.push_back(face);
        Place& next = way[k + 1];
        if (next.vertex == kNone && next.half_edge / 3 == face) {
            next.half_edge = across[next.half_edge];
            next.at = 1 - next.at;
        }
    }
    std::sort(faces.begin(), faces.end());
    if (std::adjacent_find(faces.begin(), faces.end()) != faces.end()) return false;
    for (const std::uint32_t f : faces) faces_[f] = 1;
    for (std::size_t k = 0; k < way.size(); ++k) {
        if (way[k].vertex == kNone)
            half_edges_[way[k].half_edge] = half_edges_[across[way[k].half_edge]] = 1;
        else
            vertices_[way[k].vertex] = 1;
        if (k > 0 && way[k].vertex != kNone && way[k - 1].vertex != kNone)
            set_edges(std::array{way[k - 1].vertex, way[k].vertex}, true);
    }
    return true;
}

std::vector<Place> shortest_way(const CutGraph& cut, const Occupied& occupied, std::span<const char> near,
                                std::uint32_t from, std::uint32_t to) {
    return WaySearch(cut, occupied, near, to).from(from);
}

}  // namespace dgm::bake
