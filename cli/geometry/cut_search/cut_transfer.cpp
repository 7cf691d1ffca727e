// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/cut_transfer.cpp
#include "geometry/cut_search/cut_transfer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <queue>
#include <unordered_map>
#include <vector>

#include "geometry/cut_search/cut_carry.h"
#include "geometry/mesh/infinity.h"
#include "geometry/parameterize/square_border.h"

namespace dgm::bake {
namespace {

constexpr double kDetour = 4;     // a fine path may be so many times as long as its coarse edge
constexpr int kReorderings = 20;  // of the edges, before a cut is given up

/// Shortest paths that visit a small part of a large graph.
class LocalSearch {
 public:
    explicit LocalSearch(const VertexGraph& graph) : graph_(graph) {}

    /// Vertices from `from` to `to`, both included, along arcs for which `open` holds; empty if there is no way shorter
    /// than `reach`.
    template <class Open>
    std::vector<std::uint32_t> path(std::uint32_t from, std::uint32_t to, double reach, Open open) {
        std::vector<std::uint32_t> out;
        if (!run(std::span(&from, 1), to, reach, open)) return out;
        for (std::uint32_t v = to; v != kNone; v = reached_.at(v).before) out.push_back(v);
        std::reverse(out.begin(), out.end());
        return out;
    }

    /// Vertices nearer than `reach` to one of `from`.
    [[nodiscard]] std::vector<std::uint32_t> ball(std::span<const std::uint32_t> from, double reach) {
        run(from, kNone, reach, [](const VertexGraph::Arc&) { return true; });
        std::vector<std::uint32_t> out;
        for (const auto& [v, state] : reached_) out.push_back(v);
        return out;
    }

 private:
    struct State {
        double distance;
        std::uint32_t before;
    };

    template <class Open>
    bool run(std::span<const std::uint32_t> from, std::uint32_t to, double reach, Open open) {
        reached_.clear();
        using Entry = std::pair<double, std::uint32_t>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
        for (std::uint32_t v : from) {
            reached_[v] = {0, kNone};
            queue.emplace(0.0, v);
        }
        while (!queue.empty()) {
            const auto [d, v] = queue.top();
            queue.pop();
            if (d > reached_[v].distance) continue;
            if (v == to) return true;
            for (std::uint32_t a = graph_.first[v]; a < graph_.first[v + 1]; ++a) {
                const auto& arc = graph_.arcs[a];
                const double next = d + arc.length;
                if (next > reach || !open(arc)) continue;
                const auto [it, fresh] = reached_.try_emplace(arc.to, State{kInfinity, kNone});
                // Ties go to the lower vertex, so that the order of arcs does not matter.
                if (next < it->second.distance) {
                    it->second = {next, v};
                    queue.emplace(next, arc.to);
                } else if (next == it->second.distance && it->second.before != kNone && v < it->second.before) {
                    it->second.before = v;
                }
            }
        }
        return false;
    }

    const VertexGraph& graph_;
    std::unordered_map<std::uint32_t, State> reached_;
};

/// Vertices of a border path as surface points, both ends included.
std::vector<std::uint32_t> points_of(const Disk& disk, const BorderPath& path) {
    std::vector<std::uint32_t> out;
    for (std::uint32_t h : path.half_edges) out.push_back(disk.weld[origin(disk.mesh.faces, h)]);
    out.push_back(disk.weld[target(disk.mesh.faces, path.half_edges.back())]);
    return out;
}

class Transfer {
 public:
    Transfer(CutGraph& fine, const CutGraph& coarse, std::span<const std::uint32_t> original,
             const Simplified& simplified)
        : fine_(fine),
          coarse_cut_(coarse),
          coarse_(coarse.open()),
          original_(original),
          simplified_(simplified),
          search_(fine.graph()) {}

    bool run() {
        const std::vector<BorderPath> paths = coarse_.paths();
        reset();
        for (const BorderPath& path : paths)
            for (std::uint32_t v : points_of(coarse_, path)) used_[original_[v]] = 1;
        if (!lay(paths) || !mark_all()) carry(paths);
        if (!fine_.opens_to_disk()) return false;
        straighten(0, laid_.size());
        return true;
    }

 private:
    struct Laid {
        std::vector<std::uint32_t> vertices;
        bool is_loop;
        double step;               ///< mean length of the coarse edges
        std::uint32_t middle = 0;  ///< of a loop: where its halves meet
    };

    void reset() {
        laid_.clear();
        used_.assign(fine_.graph().first.size() - 1, 0);
        const std::span<const Face> faces = fine_.mesh().faces;
        for (std::uint32_t h = 0; h < fine_.opposite().size(); ++h)
            if (fine_.opposite()[h] == kNone) used_[origin(faces, h)] = used_[target(faces, h)] = 1;
    }

    /// False, and nothing marked, if the paths do not open the mesh into one disk.
    bool mark_all() {
        for (const Laid& laid : laid_) mark(laid.vertices, true);
        if (fine_.opens_to_disk()) return true;
        for (const Laid& laid : laid_) mark(laid.vertices, false);
        return false;
    }

    /// Where handles crowd, paths find no room one after the other: all of them come through the collapses together.
    void carry(const std::vector<BorderPath>& coarse_paths) {
        reset();
        for (const auto& [a, b] : carry_cut(coarse_cut_, original_, simplified_, fine_)) mark(std::array{a, b}, true);
        double length = 0;
        std::size_t edges = 0;
        for (const BorderPath& path : coarse_paths)
            if (path.mate != kNone) {
                length += path.length;
                edges += path.half_edges.size();
            }
        const double step = edges > 0 ? length / static_cast<double>(edges) : 0;
        const Disk disk = fine_.open();
        const std::vector<BorderPath> paths = disk.paths();
        for (std::size_t p = 0; p < paths.size(); ++p) {
            if (paths[p].mate == kNone || paths[p].mate < p) continue;
            laid_.push_back({points_of(disk, paths[p]), paths[p].is_loop, step});
            for (const std::uint32_t v : laid_.back().vertices) used_[v] = 1;
        }
    }

    /// One shortest path per coarse edge, none of them through a vertex that is used. Where paths meet there is little
    /// room: edges at nodes go first, short ones before long ones; if one finds no way it goes before all others.
    bool lay(const std::vector<BorderPath>& paths) {
        struct Edge {
            std::size_t path, at;
            std::uint32_t from, to;
            double length;
            int rank;  // lower goes first
            std::vector<std::uint32_t> way;
        };
        std::vector<Edge> edges;
        for (std::size_t p = 0; p < paths.size(); ++p) {
            if (paths[p].mate == kNone || paths[p].mate < p) continue;
            const std::vector<std::uint32_t> points = points_of(coarse_, paths[p]);
            for (std::size_t k = 0; k + 1 < points.size(); ++k) {
                const Vec3d along = coarse_.mesh.positions[origin(coarse_.mesh.faces, paths[p].half_edges[k])] -
                                    coarse_.mesh.positions[target(coarse_.mesh.faces, paths[p].half_edges[k])];
                const bool at_node = k == 0 || k + 2 == points.size();
                edges.push_back(
                    {p, k, original_[points[k]], original_[points[k + 1]], length(along), at_node ? 0 : 1, {}});
            }
        }
        const std::vector<char> before = used_;
        for (int attempt = 0;; ++attempt) {
            std::stable_sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
                return x.rank != y.rank ? x.rank < y.rank : x.length < y.length;
            });
            Edge* stuck = nullptr;
            for (Edge& e : edges) {
                e.way = search_.path(e.from, e.to, kDetour * e.length,
                                     [&](const VertexGraph::Arc& arc) { return arc.to == e.to || !used_[arc.to]; });
                if (e.way.empty()) {
                    stuck = &e;
                    break;
                }
                for (std::uint32_t v : e.way) used_[v] = 1;
            }
            if (stuck == nullptr) break;
            if (attempt == kReorderings) return false;
            stuck->rank = -1 - attempt;
            used_ = before;
        }
        std::sort(edges.begin(), edges.end(),
                  [](const Edge& x, const Edge& y) { return x.path != y.path ? x.path < y.path : x.at < y.at; });
        for (const Edge& e : edges) {
            if (e.at == 0) {
                const BorderPath& path = paths[e.path];
                laid_.push_back({{e.from}, path.is_loop, path.length / static_cast<double>(path.half_edges.size())});
            }
            laid_.back().vertices.insert(laid_.back().vertices.end(), e.way.begin() + 1, e.way.end());
        }
        return true;
    }

    /// Straightens paths [first, last). A straight path may pass a handle on its other side: then half of them are
    /// tried, down to the one that stays as it is.
    void straighten(std::size_t first, std::size_t last) {
        if (first == last) return;
        const auto begin = laid_.begin() + static_cast<std::ptrdiff_t>(first),
                   end = laid_.begin() + static_cast<std::ptrdiff_t>(last);
        const std::vector<Laid> before(begin, end);
        for (auto it = begin; it != end; ++it) {
            mark(it->vertices, false);
            straighten(*it);
            mark(it->vertices, true);
        }
        if (fine_.opens_to_disk()) return;
        for (auto it = begin; it != end; ++it) {
            mark(it->vertices, false);
            use(*it, 0);
        }
        std::copy(before.begin(), before.end(), begin);
        for (auto it = begin; it != end; ++it) {
            mark(it->vertices, true);
            use(*it, 1);
        }
        if (last - first == 1) return;
        straighten(first, first + (last - first) / 2);
        straighten(first + (last - first) / 2, last);
    }

    void use(const Laid& laid, char used) {
        for (std::size_t k = 1; k + 1 < laid.vertices.size(); ++k) used_[laid.vertices[k]] = used;
    }

    /// Shortens a path within its surroundings, a loop in two halves; it stays as it is where there is no way.
    void straighten(Laid& laid) {
        if (!laid.is_loop) {
            straighten(laid, 0, laid.vertices.size() - 1);
            return;
        }
        const std::size_t middle = laid.vertices.size() / 2;
        if (middle == 0 || !straighten(laid, 0, middle)) return;
        const auto at = std::find(laid.vertices.begin() + 1, laid.vertices.end(), laid.middle);
        straighten(laid, static_cast<std::size_t>(at - laid.vertices.begin()), laid.vertices.size() - 1);
    }

    /// Replaces vertices [from, to] of a path by the shortest way near it.
    bool straighten(Laid& laid, std::size_t from, std::size_t to) {
        std::vector<std::uint32_t>& v = laid.vertices;
        laid.middle = v[to];
        const auto first = v.begin() + static_cast<std::ptrdiff_t>(from),
                   last = v.begin() + static_cast<std::ptrdiff_t>(to);
        const std::span<const std::uint32_t> part(&*first, to - from + 1);
        for (std::size_t k = 1; k + 1 < part.size(); ++k) used_[part[k]] = 0;
        std::vector<char>& near = near_;
        near.resize(used_.size(), 0);
        const std::vector<std::uint32_t> corridor = search_.ball(part, laid.step);
        for (std::uint32_t x : corridor) near[x] = 1;
        const std::vector<std::uint32_t> way =
            search_.path(part.front(), part.back(), kInfinity, [&](const VertexGraph::Arc& arc) {
                // Another path may join the same two nodes by one edge.
                return arc.to == part.back() ? !fine_.is_cut(arc.half_edge) : near[arc.to] && !used_[arc.to];
            });
        for (std::uint32_t x : corridor) near[x] = 0;
        if (way.empty()) {
            for (std::uint32_t x : part) used_[x] = 1;
            return false;
        }
        for (std::uint32_t x : way) used_[x] = 1;
        std::vector<std::uint32_t> joined(v.begin(), first);
        joined.insert(joined.end(), way.begin(), way.end());
        joined.insert(joined.end(), last + 1, v.end());
        v = std::move(joined);
        return true;
    }

    void mark(std::span<const std::uint32_t> vertices, bool cut) {
        const VertexGraph& graph = fine_.graph();
        for (std::size_t k = 0; k + 1 < vertices.size(); ++k)
            for (std::uint32_t a = graph.first[vertices[k]]; a < graph.first[vertices[k] + 1]; ++a)
                if (graph.arcs[a].to == vertices[k + 1]) fine_.mark(graph.arcs[a].half_edge, cut);
    }

    CutGraph& fine_;
    const CutGraph& coarse_cut_;
    const Disk coarse_;
    std::span<const std::uint32_t> original_;
    const Simplified& simplified_;
    LocalSearch search_;
    std::vector<char> used_;  // per fine vertex: on a path or on the border
    std::vector<char> near_;
    std::vector<Laid> laid_;
};

}  // namespace

bool transfer_cut(const CutGraph& coarse, std::span<const std::uint32_t> original, const Simplified& simplified,
                  CutGraph& fine) {
    return Transfer(fine, coarse, original, simplified).run();
}

std::optional<std::uint32_t> transfer_rotation(const Disk& coarse, std::uint32_t coarse_m, std::uint32_t coarse_n,
                                               std::uint32_t rotation, std::span<const std::uint32_t> original,
                                               const Disk& fine, std::uint32_t m, std::uint32_t n) {
    const std::uint32_t total = BorderGrid{m, n}.count();
    const std::vector<BorderPath> coarse_paths = border_paths(coarse, BorderGrid{coarse_m, coarse_n}.count()),
                                  paths = border_paths(fine, total);
    if (paths.size() != coarse_paths.size()) return std::nullopt;
    const std::vector<std::uint32_t> points = points_of(coarse, coarse_paths.front());
    const std::uint32_t from = original[points.front()], to = original[points.back()];
    std::size_t best = paths.size();
    double least = kInfinity;
    for (std::size_t p = 0; p < paths.size(); ++p) {
        const std::vector<std::uint32_t> there = points_of(fine, paths[p]);
        if (there.front() != from || there.back() != to) continue;
        const double off = std::abs(paths[p].length - coarse_paths.front().length);
        if (off < least) {
            least = off;
            best = p;
        }
    }
    if (best == paths.size()) return std::nullopt;
    const std::vector<std::uint32_t> intervals = allocate_intervals(paths, total);
    std::uint64_t before = 0;
    for (std::size_t p = 0; p < best; ++p) before += intervals[p];
    const double share = static_cast<double>(rotation) / BorderGrid{coarse_m, coarse_n}.count();
    const auto wanted = static_cast<std::uint64_t>(std::lround(share * total)) + total - before % total;
    return nearest_rotation(fine, m, n, static_cast<std::uint32_t>(wanted % total));
}

}  // namespace dgm::bake
