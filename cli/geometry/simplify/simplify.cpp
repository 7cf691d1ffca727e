// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/simplify/simplify.cpp
// [Garland, Heckbert 1997] Surface Simplification Using Quadric Error Metrics. SIGGRAPH 1997.
// [Dey, Edelsbrunner, Guha, Nekhayev 1999] Topology preserving edge contraction. Publ. Inst. Math. 66.
//
// Each vertex waits in the heap with its cheapest collapse. Costs are kept up to date; whether a collapse is allowed is
// only tested at its turn, and if it is not, the vertex waits again with its cheapest allowed one.
#include "geometry/simplify/simplify.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/mesh/infinity.h"
#include "geometry/simplify/quadric.h"
#include "geometry/simplify/vertex_heap.h"

namespace dgm::bake {
namespace {

constexpr double kThinnest = 0.02;  // doubled area over longest squared edge of a face that a collapse may make
// The same where all that is left to collapse costs much: meshes of cells that a plane cuts near their corners consist
// of slivers, and while those wait, limbs are eaten up for them.
constexpr double kThinnestAtLast = kThinnest / 1000;
// Root of a collapse's cost over the weight of its planes, against the edges of a mesh of as many faces as are wanted.
// Organs, animals and machines come to 0.35.
constexpr double kDear = 0.5, kTooDear = 2;

double longest_squared(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    return std::max({dot(a - c, a - c), dot(b - c, b - c), dot(a - b, a - b)});
}

/// The faces of a mesh that changes, and walks around its vertices.
class Rings {
 protected:
    explicit Rings(const TriMesh& mesh)
        : faces_(mesh.faces), opposite_(opposite_half_edges(mesh.faces)), out_(mesh.positions.size(), kNone) {
        for (std::uint32_t h = 0; h < opposite_.size(); ++h) {
            std::uint32_t& out = out_[origin(faces_, h)];
            if (out == kNone || opposite_[h] == kNone) out = h;
        }
    }

    [[nodiscard]] bool on_border(std::uint32_t v) const { return opposite_[out_[v]] == kNone; }

    /// Until `visit` returns true. @return whether it did
    template <class Visit>
    bool any_neighbour(std::uint32_t u, Visit visit) const {
        const std::uint32_t start = out_[u];
        std::uint32_t h = start;
        do {
            if (visit(target(faces_, h))) return true;
            const std::uint32_t back = previous_half_edge(h);
            h = opposite_[back];
            if (h == kNone && visit(origin(faces_, back))) return true;
        } while (h != kNone && h != start);
        return false;
    }
    template <class Visit>
    void each_neighbour(std::uint32_t u, Visit visit) const {
        any_neighbour(u, [&](std::uint32_t w) {
            visit(w);
            return false;
        });
    }

    std::vector<Face> faces_;
    std::vector<std::uint32_t> opposite_;
    std::vector<std::uint32_t> out_;  // a half-edge from each vertex, the border one on a border; kNone if gone
};

class Simplifier : Rings {
 public:
    Simplifier(const TriMesh& mesh, const SimplifyOptions& options)
        : Rings(mesh),
          positions_(mesh.positions),
          options_(options),
          live_faces_(mesh.faces.size()),
          quadric_(mesh.positions.size()),
          target_(mesh.positions.size(), kNone),
          seen_(mesh.positions.size(), 0),
          heap_(mesh.positions.size()) {
        make_quadrics();
    }

    Simplified run(std::size_t target_faces, const model::Progress& progress) {
        if (live_faces_ > target_faces)
            for (std::uint32_t v = 0; v < out_.size(); ++v)
                if (out_[v] != kNone) queue(v, false);
        const std::size_t start = live_faces_, wanted = std::max<std::size_t>(target_faces, 1);
        const double edge = std::sqrt(area_ / static_cast<double>(wanted));
        for (std::size_t step = 0; live_faces_ > target_faces; ++step) {
            const double dear = price() / edge;
            if (dear > kDear && allow_thinner_faces()) continue;
            if (dear > kTooDear) break;
            if (step % 4096 == 0)
                progress.update("simplify",
                                static_cast<double>(start - live_faces_) / static_cast<double>(start - target_faces));
            const std::uint32_t u = heap_.top();
            read_fan(u);
            if (allowed(u, target_[u]))
                collapse(u, target_[u]);
            else
                queue(u, true);
        }
        for (std::uint32_t f = 0; f < faces_.size(); ++f)
            if (faces_[f][0] != kNone) out_mesh_.faces.push_back(faces_[f]);
        return std::move(out_mesh_);
    }

 private:
    void make_quadrics() {
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            const Face& t = faces_[f];
            const Vec3d& p = positions_[t[0]];
            const Vec3d twice = cross(positions_[t[1]] - p, positions_[t[2]] - p), n = normalized(twice, Vec3d{});
            const double area = 0.5 * length(twice);
            area_ += area;
            for (std::uint32_t v : t) quadric_[v].add_plane(n, p, area / 3);
            for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h) {
                if (opposite_[h] != kNone) continue;
                const Vec3d& a = positions_[origin(faces_, h)];
                const Vec3d edge = positions_[target(faces_, h)] - a;
                const Vec3d side = normalized(cross(edge, n), Vec3d{});
                for (std::uint32_t v : {origin(faces_, h), target(faces_, h)})
                    quadric_[v].add_plane(side, a, options_.border_weight * dot(edge, edge) / 3);
            }
        }
    }

    /// Of the next collapse, as a length; infinity if there is none.
    [[nodiscard]] double price() const {
        if (heap_.empty()) return kInfinity;
        const std::uint32_t u = heap_.top();
        const double weight = quadric_[u].weight() + quadric_[target_[u]].weight();
        return weight > 0 ? std::sqrt(heap_.key(u) / weight) : 0;
    }

    /// Vertices without an allowed collapse wait again. False if the thinnest faces are allowed already.
    bool allow_thinner_faces() {
        if (thinnest_ <= kThinnestAtLast) return false;
        thinnest_ = std::max(0.1 * thinnest_, kThinnestAtLast);
        for (std::uint32_t v = 0; v < out_.size(); ++v)
            if (out_[v] != kNone && target_[v] == kNone) queue(v, false);
        return true;
    }

    /// Half-edges from u, counter-clockwise; a border vertex keeps its border half-edge in out_, where the fan begins.
    void read_fan(std::uint32_t u) {
        fan_.clear();
        link_.clear();
        const std::uint32_t start = out_[u];
        std::uint32_t h = start;
        do {
            fan_.push_back(h);
            link_.push_back(target(faces_, h));
            const std::uint32_t back = previous_half_edge(h);
            h = opposite_[back];
            if (h == kNone) link_.push_back(origin(faces_, back));
        } while (h != kNone && h != start);
    }

    [[nodiscard]] std::size_t most_neighbours() const { return options_.max_valence + 4; }

    /// No collapse of u, nor one into u, is allowed while this holds. Vertices of ten thousand faces are looked at
    /// again with each collapse beside them, so all that is asked about one has to end early.
    [[nodiscard]] bool is_hub(std::uint32_t u) const {
        std::size_t count = 0;
        return any_neighbour(u, [&](std::uint32_t) { return ++count > most_neighbours(); });
    }

    [[nodiscard]] double cost(std::uint32_t u, std::uint32_t v) const {
        const Quadric &a = quadric_[u], &b = quadric_[v];
        const Vec3d edge = positions_[u] - positions_[v];
        return std::max(0.0, a(positions_[v]) + b(positions_[v])) +
               options_.regularity * (a.weight() + b.weight()) * dot(edge, edge);
    }

    /// Puts u into the heap with its cheapest neighbour to go into; with `checked` (fan read) its cheapest allowed one,
    /// and out of the heap if there is none.
    void queue(std::uint32_t u, bool checked) {
        if (!options_.locked.empty() && options_.locked[u]) return;
        if (is_hub(u)) {
            target_[u] = kNone;
            heap_.erase(u);
            return;
        }
        double least = kInfinity;
        std::uint32_t best = kNone;
        const auto visit = [&](std::uint32_t v) {
            const double c = cost(u, v);
            if ((c < least || (c == least && v < best)) && (!checked || allowed(u, v))) {
                least = c;
                best = v;
            }
        };
        if (checked)
            for (std::size_t k = 0; k < link_.size(); ++k) visit(link_[k]);
        else
            each_neighbour(u, visit);
        target_[u] = best;
        if (best == kNone)
            heap_.erase(u);
        else
            heap_.set(u, least);
    }

    /// Link condition and shape, with fan and link of u read.
    [[nodiscard]] bool allowed(std::uint32_t u, std::uint32_t v) {
        const std::size_t count = link_.size();
        const auto at = static_cast<std::size_t>(std::find(link_.begin(), link_.end(), v) - link_.begin());
        const bool border = fan_.size() < count;
        if (border && at != 0 && at + 1 != count) return false;  // off the border, or from one border to another
        if (live_faces_ <= 2) return false;
        // Common neighbours must be the far corners of the faces at the edge, no others.
        const std::uint32_t before = at > 0 ? link_[at - 1] : border ? kNone : link_[count - 1];
        const std::uint32_t after = at + 1 < count ? link_[at + 1] : border ? kNone : link_[0];
        const bool bars = !options_.allow_chords && !border && on_border(v);
        ++stamp_;
        std::size_t valence = 0;
        if (any_neighbour(v, [&](std::uint32_t w) {
                seen_[w] = stamp_;
                return ++valence + count > most_neighbours();
            }))
            return false;
        for (std::uint32_t w : link_)
            if (w != before && w != after && w != v && (seen_[w] == stamp_ || (bars && on_border(w)))) return false;
        for (std::uint32_t w : {before, after})
            if (w != kNone && would_hang(u, v, w)) return false;
        return shape_holds(u, v);
    }

    /// True if without face u, v, w nothing would hold w, or two faces back to back.
    [[nodiscard]] bool would_hang(std::uint32_t u, std::uint32_t v, std::uint32_t w) const {
        const std::size_t least = on_border(w) ? 0 : 4;
        std::size_t valence = 0;
        bool stranger = false;
        return !any_neighbour(w, [&](std::uint32_t x) {
            ++valence;
            stranger |= x != u && x != v;
            return stranger && valence >= least;
        });
    }

    [[nodiscard]] bool shape_holds(std::uint32_t u, std::uint32_t v) const {
        const Vec3d &from = positions_[u], &to = positions_[v];
        for (std::uint32_t h : fan_) {
            const std::uint32_t i = target(faces_, h), j = origin(faces_, previous_half_edge(h));
            if (i == v || j == v) continue;
            const Vec3d &a = positions_[i], &b = positions_[j];
            const Vec3d old = cross(a - from, b - from), now = cross(a - to, b - to);
            const double old_area = length(old), area = length(now), agree = dot(old, now);
            if (agree < options_.least_cosine * old_area * area) return false;
            const double longest = longest_squared(a, b, to);
            if (area < thinnest_ * longest && area * longest_squared(a, b, from) < old_area * longest) return false;
        }
        return true;
    }

    /// Takes the face of half-edge h (u -> v or v -> u, u relabelled v by now) out and joins its other two edges.
    /// Returns a half-edge from v that stays.
    std::uint32_t remove_face(std::uint32_t h) {
        const std::uint32_t n = next_half_edge(h), p = previous_half_edge(h);
        const std::uint32_t w = origin(faces_, p), a = opposite_[n], b = opposite_[p];
        if (a != kNone) opposite_[a] = b;
        if (b != kNone) opposite_[b] = a;
        // a and b join w and v in opposite directions: a starts at w.
        if (out_[w] == p) out_[w] = a != kNone ? a : next_half_edge(b);
        faces_[h / 3] = {kNone, kNone, kNone};
        --live_faces_;
        return b != kNone ? b : next_half_edge(a);
    }

    void collapse(std::uint32_t u, std::uint32_t v) {
        out_mesh_.collapses.push_back({u, v, static_cast<std::uint32_t>(out_mesh_.links.size()),
                                       static_cast<std::uint32_t>(link_.size()), fan_.size() == link_.size()});
        out_mesh_.links.insert(out_mesh_.links.end(), link_.begin(), link_.end());
        const bool border = on_border(u) || on_border(v);
        std::uint32_t here = kNone, there = kNone;  // u -> v and v -> u
        for (std::uint32_t h : fan_) {
            if (target(faces_, h) == v) here = h;
            if (origin(faces_, previous_half_edge(h)) == v) there = previous_half_edge(h);
            faces_[h / 3][h % 3] = v;
        }
        std::uint32_t from = kNone;  // a half-edge from v that stays
        for (std::uint32_t h : {here, there})
            if (h != kNone) from = remove_face(h);
        if (border)
            while (opposite_[from] != kNone) from = next_half_edge(opposite_[from]);
        out_[v] = from;
        out_[u] = kNone;
        heap_.erase(u);
        quadric_[v] += quadric_[u];
        queue(v, false);
        fan_.clear();
        each_neighbour(v, [&](std::uint32_t w) { fan_.push_back(w); });
        for (std::uint32_t w : fan_) refresh(w, u, v);
    }

    /// Among w's collapses only that into v has another cost, and that into u is gone.
    void refresh(std::uint32_t w, std::uint32_t u, std::uint32_t v) {
        if (target_[w] == kNone || target_[w] == u || target_[w] == v) return queue(w, false);
        if (!options_.locked.empty() && options_.locked[w]) return;
        if (const double c = cost(w, v); c < heap_.key(w)) {
            target_[w] = v;
            heap_.set(w, c);
        }
    }

    std::span<const Vec3d> positions_;
    const SimplifyOptions& options_;
    std::size_t live_faces_;
    double area_ = 0, thinnest_ = kThinnest;
    std::vector<Quadric> quadric_;
    std::vector<std::uint32_t> target_;  // what each vertex would go into
    std::vector<std::uint32_t> seen_;
    std::uint32_t stamp_ = 0;
    VertexHeap heap_;
    std::vector<std::uint32_t> fan_, link_;
    Simplified out_mesh_;
};

}  // namespace

Simplified simplify(const TriMesh& mesh, std::size_t target_faces, const SimplifyOptions& options,
                    const model::Progress& progress) {
    return Simplifier(mesh, options).run(target_faces, progress);
}

CompactMesh compact(std::span<const Vec3d> positions, std::span<const Face> faces) {
    CompactMesh out;
    std::vector<std::uint32_t> id(positions.size(), kNone);
    for (const Face& f : faces)
        for (std::uint32_t v : f) id[v] = 0;
    for (std::uint32_t v = 0; v < id.size(); ++v)
        if (id[v] != kNone) {
            id[v] = static_cast<std::uint32_t>(out.original.size());
            out.original.push_back(v);
            out.mesh.positions.push_back(positions[v]);
        }
    out.mesh.faces.assign(faces.begin(), faces.end());
    for (Face& f : out.mesh.faces)
        for (std::uint32_t& v : f) v = id[v];
    return out;
}

}  // namespace dgm::bake
