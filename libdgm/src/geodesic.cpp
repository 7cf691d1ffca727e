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

    /// A corner of the triangles around a sample, by its representative.
    struct Corner {
        std::uint32_t sample;
        bool known;
        Vec3 at;
    };
    [[nodiscard]] Corner corner(std::uint32_t sample) const noexcept {
        const std::uint32_t r = s_.representative(sample);
        return {r, g_.accepted[r] != 0, StateImpl::at(p_, r)};
    }

    void along_edge(const Corner& v, const Corner& to) noexcept {
        const Vec3 e = to.at - v.at;
        const float gain = g_.distance[to.sample] - g_.distance[v.sample], e2 = dot(e, e);
        if (gain > 0 && e2 < gain * gain) offer(to.sample, g_.distance[v.sample] + std::sqrt(e2));
    }

    /// Distance of c from those of a and b. In units of the edge ab: the source lies at x along it and height h beyond,
    /// c at cx and height ch on this side.
    void through(const Corner& a, const Corner& b, const Corner& c) noexcept {
        const Vec3 e = b.at - a.at, f = c.at - a.at, straight = c.at - source_;
        const float length2 = dot(e, e), da = g_.distance[a.sample], db = g_.distance[b.sample];
        if (!(length2 > 0)) return;
        const float inverse = 1 / length2;
        const float x = 0.5f * ((da - db) * (da + db) * inverse + 1), cx = dot(e, f) * inverse;
        const float h2 = std::max(da * da - x * x * length2, 0.0f), ch2 = std::max(dot(f, f) - cx * cx * length2, 0.0f);
        const float both = std::sqrt(h2 * ch2), low = std::min(da, db), old = g_.distance[c.sample];
        const float across = (cx - x) * (cx - x) * length2 + h2 + ch2 + 2 * both;
        const float d2 = std::max(std::max(across, dot(straight, straight)), low * low);
        if (!(d2 < old * old)) return;
        // Where the line crosses ab. Somewhat beside it the plane still goes on much the same, farther it does not.
        const float sum = h2 + both;
        if (sum > 0 ? !(x * both + cx * h2 > -0.5f * sum && x * both + cx * h2 < 1.5f * sum) : !(x > -0.5f && x < 1.5f))
            return;
        offer(c.sample, std::sqrt(d2));
    }

    void triangle(const Corner& v, const Corner& p, const Corner& q) noexcept {
        if (p.known && q.known) {
            // Over an obtuse corner the front can come from behind: a known distance may still be too long.
            if (g_.distance[p.sample] < g_.distance[q.sample]) {
                if (dot(v.at - q.at, p.at - q.at) < 0) through(v, p, q);
            } else if (dot(v.at - p.at, q.at - p.at) < 0) {
                through(v, q, p);
            }
        } else if (p.known) {
            through(v, p, q);
        } else if (q.known) {
            through(v, q, p);
        }
    }

    void spread(std::uint32_t v) noexcept {
        if (v < s_.tables.grid && (s_.ring[v] & kRingIrregular) == 0) return spread_inside(v);
        const std::uint32_t id = s_.class_id(v);
        if (id == kNone) return spread_irregular(v, v);
        for (const std::uint32_t copy : s_.members(id)) spread_irregular(v, copy);
    }

    /// The ring of rows.h.
    void spread_inside(std::uint32_t sample) noexcept {
        const std::uint32_t n = s_.tables.cols, bits = s_.ring[sample];
        const std::uint32_t around[8] = {sample + n, sample + n + 1, sample + 1, sample - n + 1,
                                         sample - n, sample - n - 1, sample - 1, sample + n - 1};
        const Corner v{sample, true, StateImpl::at(p_, sample)};
        Corner ring[9];
        std::uint32_t count = 0;
        for (std::uint32_t k = 0; k < 8; ++k) {
            if (k % 2 != 0 && (bits >> (k / 2) & 1) == 0) continue;
            ring[count] = corner(around[k]);
            if (!ring[count].known) along_edge(v, ring[count]);
            ++count;
        }
        ring[count] = ring[0];
        for (std::uint32_t k = 0; k < count; ++k) triangle(v, ring[k], ring[k + 1]);
    }

    void spread_face(std::uint32_t v, std::uint32_t copy, const std::uint32_t* f) noexcept {
        const int k = f[0] == copy ? 0 : f[1] == copy ? 1 : f[2] == copy ? 2 : 3;
        if (k == 3) return;
        const Corner at{v, true, StateImpl::at(p_, v)}, p = corner(f[(k + 1) % 3]), q = corner(f[(k + 2) % 3]);
        if (p.sample == v || q.sample == v || p.sample == q.sample) return;
        if (!p.known) along_edge(at, p);
        if (!q.known) along_edge(at, q);
        triangle(at, p, q);
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
