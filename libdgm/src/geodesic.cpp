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

/// How far from the middle of an edge, in lengths of it, a line through its plane is still believed: a little beyond
/// its ends, where rounding and the front's own error may lay it.
constexpr float kBeside = 0.6f;

class Front {
 public:
    Front(StateImpl& s, std::uint32_t source, float radius) noexcept
        : s_(s),
          g_(s.geodesic),
          nodes_(s.geodesic.nodes.data()),
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
                unlink(nodes_[v]);
                nodes_[v].known = 1;
                spread(v);
            }
    }

 private:
    void unlink(const FrontNode& node) noexcept {
        (node.previous == kNone ? g_.head[node.bucket] : nodes_[node.previous].next) = node.next;
        if (node.next != kNone) nodes_[node.next].previous = node.previous;
    }
    void offer(std::uint32_t v, float d) noexcept {
        FrontNode& node = nodes_[v];
        if (!(d < node.distance) || !(d <= radius_)) return;
        const auto to = static_cast<std::uint16_t>(std::max(bucket_, static_cast<std::uint32_t>(d * per_bucket_)));
        if (node.distance == __builtin_inff()) {
            g_.touched[g_.touched_count++] = v;
        } else if (node.known != 0) {
            const bool worth = d < node.distance - worthwhile_ && reopened_++ <= 4 * g_.touched_count;
            node.distance = d;
            if (!worth) return;
            node.known = 0;  // its neighbours have to hear of it
        } else {
            if (node.bucket == to) {
                node.distance = d;
                return;
            }
            unlink(node);
        }
        node = {d, g_.head[to], kNone, to, 0, 0};
        if (node.next != kNone) nodes_[node.next].previous = v;
        g_.head[to] = v;
    }

    /// A corner of the triangles around a sample, by its representative.
    struct Corner {
        std::uint32_t sample;
        float distance;
        Vec3 at;
    };
    [[nodiscard]] Corner corner(std::uint32_t sample) const noexcept {
        const std::uint32_t r = s_.representative(sample);
        return {r, nodes_[r].distance, StateImpl::at(p_, r)};
    }

    void along_edge(const Corner& v, const Corner& to) noexcept {
        const Vec3 e = to.at - v.at;
        offer(to.sample, v.distance + std::sqrt(dot(e, e)));
    }

    /// Distance of c from those of a and b. In units of the edge ab: the source lies at x along it and height h beyond,
    /// c at cx and height ch on this side. @return false if the edge says nothing about c.
    bool through(const Corner& a, const Corner& b, const Corner& c) noexcept {
        const Vec3 e = b.at - a.at, f = c.at - a.at, straight = c.at - source_;
        const float length2 = dot(e, e), da = a.distance, db = b.distance;
        if (!(length2 > 0)) return false;
        const float inverse = 1 / length2;
        const float x = 0.5f * ((da - db) * (da + db) * inverse + 1), cx = dot(e, f) * inverse;
        const float h2 = std::max(da * da - x * x * length2, 0.0f), ch2 = std::max(dot(f, f) - cx * cx * length2, 0.0f);
        const float both = std::sqrt(h2 * ch2);
        // Where the line crosses ab. Beside it another plane would have to be crossed.
        const float sum = h2 + both, crossing = x * both + cx * h2;
        if (sum > 0 ? !(std::fabs(crossing - 0.5f * sum) < kBeside * sum) : !(std::fabs(x - 0.5f) < kBeside))
            return false;
        const float across = (cx - x) * (cx - x) * length2 + h2 + ch2 + 2 * both;
        offer(c.sample, std::sqrt(std::max(across, dot(straight, straight))));
        return true;
    }

    void spread(std::uint32_t v) noexcept {
        if (v < s_.tables.grid && (s_.ring[v] & kRingIrregular) == 0) return spread_inside(v);
        const std::uint32_t id = s_.class_id(v);
        if (id == kNone) return spread_irregular(v, v);
        for (const std::uint32_t copy : s_.members(id)) spread_irregular(v, copy);
    }

    /// The ring of rows.h. Only samples the front has not met get work, and those with obtuse corners: over these it
    /// can come from behind, so that a known distance may still be too long.
    void spread_inside(std::uint32_t sample) noexcept {
        const std::uint32_t n = s_.tables.cols, bits = s_.ring[sample];
        const std::uint32_t around[8] = {sample + n, sample + n + 1, sample + 1, sample - n + 1,
                                         sample - n, sample - n - 1, sample - 1, sample + n - 1};
        std::uint32_t ring[8], count = 0, known = 0, obtuse = 0;
        for (std::uint32_t k = 0; k < 8; ++k) {
            const std::uint32_t in = k % 2 == 0 ? 1 : bits >> (k / 2) & 1, r = s_.representative(around[k]);
            const std::uint32_t wide = r < s_.tables.grid ? s_.ring[r] / kRingObtuse : 1u;
            ring[count] = r;
            known |= (nodes_[r].known & in) << count;
            obtuse |= (wide & in) << count;
            count += in;
        }
        const std::uint32_t all = (1u << count) - 1;
        const Corner v{sample, nodes_[sample].distance, StateImpl::at(p_, sample)};
        for (std::uint32_t open = (~known | (known & obtuse)) & all; open != 0; open &= open - 1) {
            const auto k = static_cast<std::uint32_t>(__builtin_ctz(open));
            const Corner q = corner(ring[k]);
            const std::uint32_t before = k == 0 ? count - 1 : k - 1, after = k + 1 == count ? 0 : k + 1;
            const bool fresh = (known >> k & 1) == 0;
            bool told = false;
            for (const std::uint32_t side : {before, after})
                if ((known >> side & 1) != 0) told = through(v, corner(ring[side]), q) || told;
            if (!told && fresh) along_edge(v, q);
        }
    }

    void spread_face(std::uint32_t v, std::uint32_t copy, const std::uint32_t* f) noexcept {
        const int k = f[0] == copy ? 0 : f[1] == copy ? 1 : f[2] == copy ? 2 : 3;
        if (k == 3) return;
        const Corner at = corner(v), p = corner(f[(k + 1) % 3]), q = corner(f[(k + 2) % 3]);
        if (p.sample == v || q.sample == v || p.sample == q.sample) return;
        const bool has_p = nodes_[p.sample].known != 0, has_q = nodes_[q.sample].known != 0;
        if (!has_p) along_edge(at, p);
        if (!has_q) along_edge(at, q);
        // A known distance may still be too long: over an obtuse corner the front can come from behind.
        if (has_p) through(at, p, q);
        if (has_q) through(at, q, p);
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
    FrontNode* const nodes_;
    const ConstPlanes p_;
    const Vec3 source_;
    const float radius_, per_bucket_;
    const float worthwhile_ = radius_ * 1e-5f;  ///< shorter improvements are not worth another turn
    std::uint32_t bucket_ = 0;
    std::uint32_t reopened_ = 0;  ///< bounded: crumpled surfaces could go on correcting for long
};
}  // namespace

void begin_geodesic(StateImpl& s, std::uint32_t start, float radius) noexcept {
    Front(s, start, radius).run();
}

void end_geodesic(StateImpl& s) noexcept {
    GeodesicScratch& g = s.geodesic;
    for (std::uint32_t k = 0; k < g.touched_count; ++k) g.nodes[g.touched[k]] = {};
    g.touched_count = 0;
}

}  // namespace dgm::detail
