// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/straight_cut.cpp
#include "geometry/cut_search/straight_cut.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <queue>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "geometry/cut_search/face_way.h"
#include "geometry/mesh/infinity.h"

namespace dgm::bake {
namespace {

constexpr int kTries = 24;  // maps from pieces to surfaces, to find out which pieces had better stay

/// The piece of the cut between two nodes; a loop has two, which meet at its middle.
struct Piece {
    std::vector<std::uint32_t> vertices;
    double reach;
};

std::vector<Piece> pieces_of(const CutGraph& cut, double reach) {
    std::vector<Piece> pieces;
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
            pieces.push_back({std::move(way), step});
            continue;
        }
        const auto middle = way.begin() + static_cast<std::ptrdiff_t>(way.size() / 2);
        pieces.push_back({{way.begin(), middle + 1}, step});
        pieces.push_back({{middle, way.end()}, step});
    }
    return pieces;
}

/// Vertices within the reach of a piece, by edges.
std::vector<std::uint32_t> surroundings(const VertexGraph& graph, const Piece& piece) {
    std::unordered_map<std::uint32_t, double> distance;
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    for (const std::uint32_t v : piece.vertices) {
        distance[v] = 0;
        queue.emplace(0.0, v);
    }
    std::vector<std::uint32_t> out;
    while (!queue.empty()) {
        const auto [d, v] = queue.top();
        queue.pop();
        if (d > distance[v]) continue;
        out.push_back(v);
        for (std::uint32_t a = graph.first[v]; a < graph.first[v + 1]; ++a) {
            const double next = d + graph.arcs[a].length;
            if (next > piece.reach) continue;
            const auto [it, fresh] = distance.try_emplace(graph.arcs[a].to, kInfinity);
            if (next < it->second) {
                it->second = next;
                queue.emplace(next, it->first);
            }
        }
    }
    return out;
}

/// A shorter way for a piece, occupied for the others; empty if the piece stays as it was.
/// @param near  zero per vertex, before and after
std::vector<Place> straightened(const CutGraph& cut, const Piece& piece, Occupied& occupied, std::vector<char>& near) {
    const std::vector<std::uint32_t>& old = piece.vertices;
    occupied.set_edges(old, false);
    const std::vector<std::uint32_t> ball = surroundings(cut.graph(), piece);
    for (const std::uint32_t v : ball) near[v] = 1;
    std::vector<Place> way = shortest_way(cut, occupied, near, old.front(), old.back());
    for (const std::uint32_t v : ball) near[v] = 0;
    if (!way.empty()) relax_way(cut.mesh(), way);
    if (!way.empty() && way_cost(cut, way) < way_cost(cut, old) && occupied.add(way)) return way;
    occupied.set_edges(old, true);
    return {};
}

/// Cuts `mesh` along ways over its vertices; nothing if that opens no disk.
std::optional<Disk> opened_along(const TriMesh& mesh, const std::vector<std::vector<std::uint32_t>>& ways) {
    CutGraph straight(mesh);
    const VertexGraph& graph = straight.graph();
    for (const std::vector<std::uint32_t>& way : ways)
        for (std::size_t k = 0; k + 1 < way.size(); ++k)
            for (std::uint32_t a = graph.first[way[k]]; a < graph.first[way[k] + 1]; ++a)
                if (graph.arcs[a].to == way[k + 1]) straight.mark(graph.arcs[a].half_edge, true);
    if (!straight.opens_to_disk()) return std::nullopt;
    return straight.open();
}

/// Finds the pieces of a cut that can be straight together.
class StraightPieces {
 public:
    StraightPieces(const CutGraph& cut, double reach) : cut_(cut), pieces_(pieces_of(cut, reach)) {}

    [[nodiscard]] Disk open() {
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
            const auto begin = chosen.begin() + static_cast<std::ptrdiff_t>(from),
                       end = chosen.begin() + static_cast<std::ptrdiff_t>(to);
            std::fill(begin, end, 1);
            if (opened(chosen)) continue;
            std::fill(begin, end, 0);
            choose(chosen, from, to);
        }
    }

    /// The surface opened with the chosen pieces straight; nothing if that is no disk.
    [[nodiscard]] std::optional<Disk> opened(const std::vector<char>& chosen) const {
        Occupied occupied(cut_);
        std::vector<char> near(cut_.mesh().positions.size(), 0);
        std::vector<std::vector<Place>> ways(pieces_.size());
        for (std::size_t k = 0; k < pieces_.size(); ++k)
            if (chosen[k]) ways[k] = straightened(cut_, pieces_[k], occupied, near);
        TriMesh mesh = cut_.mesh();
        std::vector<std::uint32_t> across(cut_.opposite().begin(), cut_.opposite().end());
        std::vector<std::vector<std::uint32_t>> vertices(pieces_.size());
        for (std::size_t k = 0; k < pieces_.size(); ++k) {
            if (ways[k].empty()) vertices[k] = pieces_[k].vertices;
            for (const Place& p : ways[k])
                vertices[k].push_back(p.vertex != kNone ? p.vertex
                                                        : split_edge(mesh, across, p.half_edge, p.at).vertex);
        }
        return opened_along(mesh, vertices);
    }

    const CutGraph& cut_;
    const std::vector<Piece> pieces_;
    int tries_ = 0;
};

}  // namespace

Disk open_straight(const CutGraph& cut, double reach) {
    return StraightPieces(cut, reach).open();
}

}  // namespace dgm::bake
