// SPDX-License-Identifier: MIT
// libdgm/src/geodesic.cpp
// Distances on the rest surface around a sample: a front that runs outwards over the welded triangles.
//
// A triangle with two known corners is unfolded into the plane of the front: their distances place the source, and the
// third corner's distance is the straight line to it [Novotni, Klein 2002: Computing geodesic distances on triangular
// meshes]. Exact on everything that unrolls into a plane; a straight line through space bounds it from below.
// Our choice: a bucket queue of kBuckets widths instead of a heap; within one width the order is free.
#include <algorithm>
#include <cmath>

#include "state_impl.h"

namespace dgm::detail {
namespace {

class Front {
 public:
    Front(StateImpl& s, std::uint32_t source, float radius) noexcept
        : s_(s),
          g_(s.geodesic),
          p_(StateImpl::fixed(s.rest)),
          source_(StateImpl::at(p_, source)),
          radius_(radius),
          per_bucket_(static_cast<float>(GeodesicScratch::kBuckets - 1) / radius) {
        offer(s.representative(source), 0);
    }

    void run() noexcept {
        for (; bucket_ < GeodesicScratch::kBuckets; ++bucket_)
            while (g_.head[bucket_] != kNone) {
                const std::uint32_t v = g_.head[bucket_];
                unlink(v);
                g_.accepted[v] = 1;
                spread(v);
            }
    }

 private:
    [[nodiscard]] std::uint32_t bucket_of(float d) const noexcept {
        return std::max(bucket_, static_cast<std::uint32_t>(d * per_bucket_));
    }
    void unlink(std::uint32_t v) noexcept {
        const std::uint32_t next = g_.next[v], previous = g_.previous[v];
        (previous == kNone ? g_.head[g_.bucket[v]] : g_.next[previous]) = next;
        if (next != kNone) g_.previous[next] = previous;
    }
    void offer(std::uint32_t v, float d) noexcept {
        if (!(d < g_.distance[v]) || !(d <= radius_)) return;
        const auto to = static_cast<std::uint16_t>(bucket_of(d));
        if (g_.distance[v] == __builtin_inff()) {
            g_.touched[g_.touched_count++] = v;
        } else if (g_.accepted[v] != 0) {
            if (!(d < g_.distance[v] - worthwhile_) || reopened_++ > 4 * g_.touched_count) return;
            g_.accepted[v] = 0;  // its neighbours have to hear of it
        } else {
            if (g_.bucket[v] == to) {
                g_.distance[v] = d;
                return;
            }
            unlink(v);
        }
        g_.distance[v] = d;
        g_.bucket[v] = to;
        g_.previous[v] = kNone;
        g_.next[v] = g_.head[to];
        if (g_.head[to] != kNone) g_.previous[g_.head[to]] = v;
        g_.head[to] = v;
    }

    void along_edge(std::uint32_t v, std::uint32_t to) noexcept {
        const Vec3 e = StateImpl::at(p_, to) - StateImpl::at(p_, v);
        offer(to, g_.distance[v] + std::sqrt(dot(e, e)));
    }

    /// Distance of c from those of a and b. In units of the edge ab: the source lies at x along it and height h beyond,
    /// c at cx and height ch on this side.
    void through(std::uint32_t a, std::uint32_t b, std::uint32_t c) noexcept {
        const Vec3 A = StateImpl::at(p_, a), C = StateImpl::at(p_, c);
        const Vec3 e = StateImpl::at(p_, b) - A, f = C - A, straight = C - source_;
        const float length2 = dot(e, e), da = g_.distance[a], db = g_.distance[b];
        if (!(length2 > 0)) return;
        const float inverse = 1 / length2;
        const float x = 0.5f * ((da - db) * (da + db) * inverse + 1), cx = dot(e, f) * inverse;
        const float h2 = std::max(da * da - x * x * length2, 0.0f), ch2 = std::max(dot(f, f) - cx * cx * length2, 0.0f);
        const float both = std::sqrt(h2 * ch2);
        // Where the line crosses ab. Somewhat beside it the plane still goes on much the same, farther it does not.
        const float share = h2 + both > 0 ? h2 / (h2 + both) : 0;
        const float crossing = x + (cx - x) * share;
        if (!(crossing > -0.5f && crossing < 1.5f)) return;
        const float across = (cx - x) * (cx - x) * length2 + h2 + ch2 + 2 * both;
        offer(c, std::max(std::sqrt(std::max(across, dot(straight, straight))), std::min(da, db)));
    }

    void triangle(std::uint32_t v, std::uint32_t p, std::uint32_t q) noexcept {
        const bool has_p = g_.accepted[p] != 0, has_q = g_.accepted[q] != 0;
        if (has_p && has_q) {
            // Over an obtuse corner the front can come from behind: a known distance may still be too long.
            if (is_obtuse(q, v, p)) through(v, p, q);
            if (is_obtuse(p, v, q)) through(v, q, p);
        } else if (has_p) {
            through(v, p, q);
        } else if (has_q) {
            through(v, q, p);
        }
    }
    [[nodiscard]] bool is_obtuse(std::uint32_t corner, std::uint32_t a, std::uint32_t b) const noexcept {
        const Vec3 at = StateImpl::at(p_, corner);
        return dot(StateImpl::at(p_, a) - at, StateImpl::at(p_, b) - at) < 0;
    }

    void spread(std::uint32_t v) noexcept {
        if (v < s_.tables.grid && (s_.ring[v] & kRingIrregular) == 0) return spread_inside(v);
        const std::uint32_t id = s_.class_id(v);
        if (id == kNone) return spread_irregular(v, v);
        for (const std::uint32_t copy : s_.members(id)) spread_irregular(v, copy);
    }

    /// The ring of rows.h. It may hold seam samples, so all are taken by their representatives.
    void spread_inside(std::uint32_t v) noexcept {
        const std::uint32_t n = s_.tables.cols;
        const std::uint32_t around[8] = {v + n, v + n + 1, v + 1, v - n + 1, v - n, v - n - 1, v - 1, v + n - 1};
        std::uint32_t ring[9], count = 0;
        for (std::uint32_t k = 0; k < 8; ++k)
            if (k % 2 == 0 || (s_.ring[v] >> (k / 2) & 1) != 0) ring[count++] = s_.representative(around[k]);
        ring[count] = ring[0];
        for (std::uint32_t k = 0; k < count; ++k)
            if (g_.accepted[ring[k]] == 0) along_edge(v, ring[k]);
        for (std::uint32_t k = 0; k < count; ++k) triangle(v, ring[k], ring[k + 1]);
    }

    void spread_face(std::uint32_t v, std::uint32_t copy, const std::uint32_t* f) noexcept {
        const int k = f[0] == copy ? 0 : f[1] == copy ? 1 : f[2] == copy ? 2 : 3;
        if (k == 3) return;
        const std::uint32_t p = s_.representative(f[(k + 1) % 3]), q = s_.representative(f[(k + 2) % 3]);
        if (p == v || q == v || p == q) return;
        if (g_.accepted[p] == 0) along_edge(v, p);
        if (g_.accepted[q] == 0) along_edge(v, q);
        triangle(v, p, q);
    }

    void spread_irregular(std::uint32_t v, std::uint32_t copy) noexcept {
        const ChartTables& t = s_.tables;
        if (copy < t.grid) {
            const std::uint32_t i = copy / t.cols, j = copy % t.cols;
            for (std::uint32_t qi = i == 0 ? 0 : i - 1; qi <= i && qi + 1 < t.rows; ++qi)
                for (std::uint32_t qj = j == 0 ? 0 : j - 1; qj <= j && qj + 1 < t.cols; ++qj) {
                    if (!t.has_quad(qi, qj)) continue;
                    for (const auto& f : quad_triangles(qi, qj, t.cols, t.diagonal(qi, qj)))
                        spread_face(v, copy, f.data());
                }
        }
        if (s_.face_start.empty()) return;
        for (std::uint32_t k = s_.face_start[copy]; k < s_.face_start[copy + 1]; ++k)
            spread_face(v, copy, s_.faces.data() + 3 * std::size_t{s_.face_of[k]});
    }

    StateImpl& s_;
    GeodesicScratch& g_;
    const ConstPlanes p_;
    const Vec3 source_;
    const float radius_, per_bucket_;
    const float worthwhile_ = radius_ * 1e-4f;  ///< shorter improvements are not worth another turn
    std::uint32_t bucket_ = 0;
    std::uint32_t reopened_ = 0;  ///< bounded: crumpled surfaces could go on correcting for long
};
}  // namespace

void begin_geodesic(StateImpl& s, std::uint32_t start, float radius) noexcept {
    Front(s, start, radius).run();
}

void end_geodesic(StateImpl& s) noexcept {
    GeodesicScratch& g = s.geodesic;
    for (std::uint32_t k = 0; k < g.touched_count; ++k) {
        g.distance[g.touched[k]] = __builtin_inff();
        g.accepted[g.touched[k]] = 0;
    }
    g.touched_count = 0;
}

}  // namespace dgm::detail
