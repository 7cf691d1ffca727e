// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/open_one_sided.cpp
// [Erickson, Whittlesey 2005] Greedy optimal homotopy and homology generators. SODA 2005.
//
// Edges that a tree of faces does not cross cut any surface into a disk, and a disk has two sides. Our choice: most of
// these edges are glued again, since the faces on both sides of them agree; the others form the curve.
#include "geometry/repair/open_one_sided.h"

#include <algorithm>
#include <queue>

#include "geometry/mesh/infinity.h"
#include "geometry/mesh/union_find.h"

namespace dgm::bake {
namespace {

constexpr int kRoots = 8;  // points tried on a closed surface

class Opener {
 public:
    Opener(const FaceSoup& soup, std::span<const std::uint32_t> faces, std::span<const std::uint32_t> partner)
        : soup_(soup), faces_(faces), partner_(partner), place_(soup.faces.size(), kNone) {
        for (std::uint32_t k = 0; k < faces.size(); ++k) place_[faces[k]] = k;
        name_vertices();
        collect_edges();
    }

    [[nodiscard]] const std::vector<std::uint32_t>& border() const { return border_; }

    /// Distances along edges; marks the edges of the shortest paths.
    void search(std::span<const std::uint32_t> roots) {
        distance_.assign(arcs_.size(), kInfinity);
        std::vector<std::uint32_t> reached_by(arcs_.size(), kNone);
        using Entry = std::pair<double, std::uint32_t>;
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
        for (const std::uint32_t v : roots) {
            distance_[v] = 0;
            queue.emplace(0.0, v);
        }
        while (!queue.empty()) {
            const auto [d, v] = queue.top();
            queue.pop();
            if (d > distance_[v]) continue;
            for (const std::uint32_t e : arcs_[v]) {
                const std::uint32_t w = edges_[e].a == v ? edges_[e].b : edges_[e].a;
                const double there = d + edges_[e].length;
                if (!(there < distance_[w])) continue;
                distance_[w] = there;
                reached_by[w] = e;
                queue.emplace(there, w);
            }
        }
        for (Edge& e : edges_) e.on_path = false;
        for (const std::uint32_t e : reached_by)
            if (e != kNone) edges_[e].on_path = true;
    }

    [[nodiscard]] const std::vector<double>& distance() const { return distance_; }

    /// Windings that agree along the tree of faces, by place; the first face keeps its own.
    [[nodiscard]] std::vector<char> turn_along_tree() const {
        std::vector<std::uint32_t> order(edges_.size());
        for (std::uint32_t e = 0; e < order.size(); ++e) order[e] = e;
        const auto loop = [&](const Edge& e) { return distance_[e.a] + distance_[e.b] + e.length; };
        std::sort(order.begin(), order.end(), [&](std::uint32_t x, std::uint32_t y) {
            const Edge &e = edges_[x], &f = edges_[y];
            if (e.on_path != f.on_path) return f.on_path;
            const double le = loop(e), lf = loop(f);
            return le != lf ? le > lf : x < y;
        });
        UnionFind joined(faces_.size());
        std::vector<std::vector<std::uint32_t>> crossed(faces_.size());
        for (const std::uint32_t e : order) {
            const std::uint32_t g = partner_[edges_[e].half_edge];
            if (g == kNone) continue;
            const std::uint32_t f = place_[edges_[e].half_edge / 3], other = place_[g / 3];
            if (!joined.unite(f, other)) continue;
            crossed[f].push_back(edges_[e].half_edge);
            crossed[other].push_back(g);
        }
        std::vector<char> turned(faces_.size(), 2);
        std::vector<std::uint32_t> walk{0};
        turned[0] = 0;
        for (std::size_t at = 0; at < walk.size(); ++at)
            for (const std::uint32_t h : crossed[walk[at]]) {
                const std::uint32_t to = place_[partner_[h] / 3];
                if (turned[to] != 2) continue;
                turned[to] = static_cast<char>((turned[walk[at]] != 0) == runs_on(h));
                walk.push_back(to);
            }
        return turned;
    }

    /// Turns faces while that shortens the curve. Such a face meets at most one other that is not across the curve, so
    /// the opened surface stays in one piece.
    void shorten(std::vector<char>& turned) const {
        std::vector<std::uint32_t> open(faces_.size());
        for (std::uint32_t k = 0; k < open.size(); ++k) open[k] = k;
        for (std::size_t at = 0; at < open.size(); ++at) {
            const std::uint32_t f = open[at];
            double across = 0, joined = 0;
            int joints = 0;
            for (std::uint32_t h = 3 * faces_[f]; h < 3 * faces_[f] + 3; ++h) {
                if (partner_[h] == kNone || partner_[h] / 3 == faces_[f]) continue;
                (disagree(turned, h) ? across : joined) += edge_length(h);
                joints += !disagree(turned, h);
            }
            if (joints > 1 || !(across > joined * (1 + 1e-9))) continue;
            turned[f] = static_cast<char>(!turned[f]);
            for (std::uint32_t h = 3 * faces_[f]; h < 3 * faces_[f] + 3; ++h)
                if (partner_[h] != kNone) open.push_back(place_[partner_[h] / 3]);
        }
    }

    [[nodiscard]] double curve_length(const std::vector<char>& turned) const {
        double sum = 0;
        for (const Edge& e : edges_)
            if (partner_[e.half_edge] != kNone && disagree(turned, e.half_edge)) sum += e.length;
        return sum;
    }

 private:
    struct Edge {
        std::uint32_t a, b;
        double length;
        std::uint32_t half_edge;
        bool on_path = false;
    };

    /// True if the faces on both sides of h run along it in opposite directions, as neighbours that agree do.
    [[nodiscard]] bool runs_on(std::uint32_t h) const {
        return origin(soup_.faces, h) != origin(soup_.faces, partner_[h]);
    }
    [[nodiscard]] bool disagree(const std::vector<char>& turned, std::uint32_t h) const {
        return runs_on(h) != (turned[place_[h / 3]] == turned[place_[partner_[h] / 3]]);
    }
    [[nodiscard]] double edge_length(std::uint32_t h) const {
        return length(soup_.positions[target(soup_.faces, h)] - soup_.positions[origin(soup_.faces, h)]);
    }

    /// Corners that gluing joins are one vertex; vertices are numbered in the order of the faces.
    void name_vertices() {
        UnionFind corners(3 * faces_.size());
        const auto corner = [&](std::uint32_t h) { return 3 * place_[h / 3] + h % 3; };
        const auto at = [&](std::uint32_t h, std::uint32_t v) {
            return corner(origin(soup_.faces, h) == v ? h : next_half_edge(h));
        };
        for (const std::uint32_t f : faces_)
            for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h)
                if (partner_[h] != kNone)
                    for (const std::uint32_t v : {origin(soup_.faces, h), target(soup_.faces, h)})
                        corners.unite(at(h, v), at(partner_[h], v));
        vertex_.resize(3 * faces_.size());
        std::vector<std::uint32_t> number(vertex_.size(), kNone);
        std::uint32_t count = 0;
        for (std::uint32_t c = 0; c < vertex_.size(); ++c) {
            std::uint32_t& id = number[corners.find(c)];
            if (id == kNone) id = count++;
            vertex_[c] = id;
        }
        arcs_.resize(count);
    }

    void collect_edges() {
        std::vector<char> on_border(arcs_.size(), 0);
        for (std::uint32_t k = 0; k < faces_.size(); ++k)
            for (std::uint32_t i = 0; i < 3; ++i) {
                const std::uint32_t h = 3 * faces_[k] + i, a = vertex_[3 * k + i], b = vertex_[3 * k + (i + 1) % 3];
                if (partner_[h] != kNone && partner_[h] < h) continue;
                for (const std::uint32_t v : {a, b}) arcs_[v].push_back(static_cast<std::uint32_t>(edges_.size()));
                edges_.push_back({a, b, edge_length(h), h});
                if (partner_[h] == kNone) on_border[a] = on_border[b] = 1;
            }
        for (std::uint32_t v = 0; v < on_border.size(); ++v)
            if (on_border[v]) border_.push_back(v);
    }

    const FaceSoup& soup_;
    std::span<const std::uint32_t> faces_, partner_;
    std::vector<std::uint32_t> place_;   ///< of each face of the soup, its number among `faces_`
    std::vector<std::uint32_t> vertex_;  ///< of each corner
    std::vector<Edge> edges_;
    std::vector<std::vector<std::uint32_t>> arcs_;  ///< edges at each vertex
    std::vector<std::uint32_t> border_;
    std::vector<double> distance_;
};

}  // namespace

void open_one_sided(const FaceSoup& soup, std::span<const std::uint32_t> faces, std::span<const std::uint32_t> partner,
                    std::vector<char>& turned) {
    Opener opener(soup, faces, partner);
    std::vector<char> best;
    double least = kInfinity;
    std::vector<double> to_roots;
    std::uint32_t root = 0;
    for (int k = 0; k < (opener.border().empty() ? kRoots : 1); ++k) {
        opener.search(opener.border().empty() ? std::span<const std::uint32_t>(&root, 1) : opener.border());
        std::vector<char> found = opener.turn_along_tree();
        opener.shorten(found);
        if (const double length = opener.curve_length(found); length < least) {
            least = length;
            best = std::move(found);
        }
        // The next point is the farthest from all before it.
        if (to_roots.empty()) to_roots.assign(opener.distance().size(), kInfinity);
        for (std::size_t v = 0; v < to_roots.size(); ++v) to_roots[v] = std::min(to_roots[v], opener.distance()[v]);
        root = static_cast<std::uint32_t>(std::max_element(to_roots.begin(), to_roots.end()) - to_roots.begin());
    }
    for (std::size_t k = 0; k < faces.size(); ++k) turned[faces[k]] = best[k];
}

}  // namespace dgm::bake
