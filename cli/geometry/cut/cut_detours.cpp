// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut/cut_detours.cpp
// Shortens a cut by exchanging its paths for shorter ones: CutGraph's shorten() and reroute().
#include <algorithm>
#include <array>
#include <functional>
#include <queue>
#include <utility>

#include "geometry/cut/cut_graph.h"

namespace dgm::bake {
namespace {

/// The surface as the cut opens it, without making it: a vertex of it is a sector between cut edges about a vertex, and
/// is called by its first half-edge, clockwise (by its lowest, if nothing is cut there).
struct OpenedView {
    const CutGraph& cut;
    std::span<const std::uint32_t> opposite;

    [[nodiscard]] bool blocked(std::uint32_t h) const { return opposite[h] == kNone || cut.is_cut(h); }
    [[nodiscard]] std::uint32_t next_border(std::uint32_t h) const {
        std::uint32_t g = next_half_edge(h);
        while (!blocked(g)) g = next_half_edge(opposite[g]);
        return g;
    }
    [[nodiscard]] std::uint32_t sector(std::uint32_t h) const {
        std::uint32_t lowest = h;
        for (std::uint32_t g = h; !blocked(g);) {
            g = next_half_edge(opposite[g]);
            if (g == h) return lowest;
            lowest = blocked(g) ? g : std::min(lowest, g);
        }
        return blocked(h) ? h : lowest;
    }
    [[nodiscard]] std::vector<std::uint32_t> border_loop(std::uint32_t start) const {
        std::vector<std::uint32_t> out;
        std::uint32_t h = start;
        do {
            out.push_back(h);
            h = next_border(h);
        } while (h != start);
        return out;
    }
};

}  // namespace

/// Memory of a search for another way, kept from path to path: numbers per half-edge, valid where `stamp` is current.
struct CutGraph::Detours {
    explicit Detours(std::size_t half_edges)
        : distance(half_edges), arc(half_edges), from(half_edges), stamp(half_edges, 0), goal(half_edges, 0) {}
    std::vector<double> distance;
    std::vector<std::uint32_t> arc, from, stamp, goal;
    std::uint32_t now = 0;
};

/// Without one of its paths a cut leaves an annulus (or, without a dead end, a disk still), and every path between the
/// annulus' two borders opens it again. The shortest one may end anywhere on them, so that nodes wander to where the
/// network is short: each exchange lowers the length, none can break the topology.
void CutGraph::shorten() {
    constexpr std::size_t kWork =
        30'000'000;  // faces visited: some seconds; only huge bodies with many handles feel it
    const std::size_t most = std::max<std::size_t>(kWork / mesh_->faces.size(), 8);
    std::size_t tried = 0;
    Detours detours(opposite_.size());
    for (bool shorter = true; shorter;) {
        shorter = false;
        std::vector<BorderPath> paths = open().paths();
        std::stable_sort(paths.begin(), paths.end(),
                         [](const BorderPath& a, const BorderPath& b) { return a.length > b.length; });
        for (const BorderPath& path : paths) {
            const bool stands =
                std::all_of(path.half_edges.begin(), path.half_edges.end(), [&](std::uint32_t h) { return cut_[h]; });
            // One of each pair of mates. A path that an exchange of this round has met at its middle leaves no annulus;
            // its parts have their turn in the next round.
            if (path.mate == kNone || !stands || path.half_edges.front() > opposite_[path.half_edges.back()]) continue;
            if (++tried > most) return;
            double cost = 0;
            for (const std::uint32_t h : path.half_edges) cost += edge_cost(h);
            shorter = reroute(path.half_edges, cost, detours) || shorter;
        }
    }
}

bool CutGraph::reroute(std::span<const std::uint32_t> half_edges, double old_cost, Detours& detours) {
    const OpenedView opened{*this, opposite_};
    // Both sides of the path must be whole, and something must lie between them on either way round the border.
    for (std::size_t k = 0; k + 1 < half_edges.size(); ++k)
        if (opened.next_border(half_edges[k]) != half_edges[k + 1] ||
            opened.next_border(opposite_[half_edges[k + 1]]) != opposite_[half_edges[k]])
            return false;
    const std::array<std::uint32_t, 2> loops{opened.next_border(half_edges.back()),
                                             opened.next_border(opposite_[half_edges.front()])};
    if (loops[0] == opposite_[half_edges.back()] || loops[1] == half_edges.front()) return false;
    for (const std::uint32_t h : half_edges) mark(h, false);

    std::array<std::vector<std::uint32_t>, 2> sides{opened.border_loop(loops[0]), opened.border_loop(loops[1])};
    if (sides[1].size() < sides[0].size()) sides[0].swap(sides[1]);
    Detours& d = detours;
    ++d.now;
    for (const std::uint32_t h : sides[1]) d.goal[h] = d.now;
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    for (const std::uint32_t h : sides[0]) {
        d.distance[h] = 0;
        d.arc[h] = kNone;
        d.stamp[h] = d.now;
        queue.emplace(0.0, h);
    }
    const double limit = (1 - 1e-6) * old_cost;
    while (!queue.empty()) {
        const auto [distance, at] = queue.top();
        queue.pop();
        if (distance > d.distance[at]) continue;
        if (!(distance < limit)) break;
        if (d.goal[at] == d.now) {
            for (std::uint32_t w = at; d.arc[w] != kNone; w = d.from[w]) mark(d.arc[w], true);
            prune();
            return true;
        }
        for (std::uint32_t h = at;;) {
            if (!opened.blocked(h)) {
                const std::uint32_t to = opened.sector(opposite_[h]);
                const double along = distance + edge_cost(h);
                if (d.stamp[to] != d.now || along < d.distance[to]) {
                    d.distance[to] = along;
                    d.arc[to] = h;
                    d.from[to] = at;
                    d.stamp[to] = d.now;
                    if (along < limit) queue.emplace(along, to);
                }
            }
            const std::uint32_t before = previous_half_edge(h);
            if (opened.blocked(before)) break;
            h = opposite_[before];
            if (h == at) break;
        }
    }
    for (const std::uint32_t h : half_edges) mark(h, true);
    return false;
}

}  // namespace dgm::bake
