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
#include <utility>

#include "patch.h"
#include "state_impl.h"
#include "table_impl.h"

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
          marks_(s.geodesic.marks.data()),
          heads_(s.total()),
          p_(StateImpl::fixed(s.rest)),
          source_(StateImpl::at(p_, source)),
          radius2_(radius * radius),
          per_bucket_(static_cast<float>(GeodesicScratch::kBuckets - 1) / radius),
          worthwhile_(radius * 1e-5f) {
        const std::uint32_t n = s.tables.cols;
        const std::uint32_t around[8] = {n, n + 1, 1, 1 - n, 0 - n, 0 - n - 1, 0u - 1, n - 1};  // modulo 2^32
        std::copy_n(around, 8, around_);
        offer(s.representative(source), 0);
    }

    void run() noexcept {
        for (; bucket_ < GeodesicScratch::kBuckets; ++bucket_)
            for (std::uint32_t v; (v = nodes_[heads_ + bucket_].next) != heads_ + bucket_;) {
                unlink(nodes_[v]);
                marks_[v] |= kFrontKnown;
                if (v < s_.tables.grid && (s_.ring[v] & kRingInside) != 0)
                    spread_inside(v);
                else
                    spread_outside(v);
            }
    }

 private:
    void unlink(const FrontNode& node) noexcept {
        nodes_[node.previous].next = node.next;
        nodes_[node.next].previous = node.previous;
    }
    /// A way of this length, squared, to v.
    [[gnu::always_inline]] void offer(std::uint32_t v, float d2) noexcept {
        FrontNode& node = nodes_[v];
        if (!(d2 < node.distance * node.distance) || !(d2 <= radius2_)) return;
        const float d = std::sqrt(d2);
        const std::uint32_t to = std::max(bucket_, static_cast<std::uint32_t>(d * per_bucket_));
        if (node.distance == __builtin_inff()) {
            g_.touched[g_.touched_count++] = v;
        } else if ((marks_[v] & kFrontKnown) != 0) {
            const bool worth = d < node.distance - worthwhile_ && reopened_++ <= 4 * g_.touched_count;
            node.distance = d;
            if (!worth) return;
            marks_[v] &= static_cast<std::uint8_t>(~kFrontKnown);  // its neighbours have to hear of it
        } else {
            node.distance = d;
            if (node.bucket == to) return;
            unlink(node);
        }
        FrontNode& head = nodes_[heads_ + to];
        node = {d, head.next, heads_ + to, to};
        nodes_[head.next].previous = v;
        head.next = v;
    }

    /// A corner of the triangles around a sample, by its representative.
    struct Corner {
        std::uint32_t sample;
        float distance;
        Vec3 at;
    };
    [[nodiscard, gnu::always_inline]] Corner corner(std::uint32_t r) const noexcept {
        return {r, nodes_[r].distance, StateImpl::at(p_, r)};
    }

    [[gnu::always_inline]] void along_edge(const Corner& v, std::uint32_t to) noexcept {
        const Vec3 e = StateImpl::at(p_, to) - v.at;
        const float length2 = dot(e, e), room = nodes_[to].distance - v.distance;
        if (!(room > 0) || !(length2 < room * room)) return;
        const float d = v.distance + std::sqrt(length2);
        offer(to, d * d);
    }

    /// Distance of c from those of a and b. In units of the edge ab: the source lies at x along it and height h beyond,
    /// c at cx and height ch on this side. @return false if the edge says nothing about c.
    [[gnu::always_inline]] bool through(const Corner& a, const Corner& b, std::uint32_t sample) noexcept {
        const Vec3 at = StateImpl::at(p_, sample), e = b.at - a.at, f = at - a.at;
        const float length2 = dot(e, e), da = a.distance, db = b.distance;
        if (!(length2 > 0)) return false;
        const float inverse = 1 / length2;
        const float x = 0.5f * ((da - db) * (da + db) * inverse + 1), cx = dot(e, f) * inverse;
        const float h2 = std::max(da * da - x * x * length2, 0.0f), ch2 = std::max(dot(f, f) - cx * cx * length2, 0.0f);
        const float both = std::sqrt(h2 * ch2);
        // Where the line crosses ab. Beside it another plane would have to be crossed.
        const float sum = h2 + both, aside = x * both + cx * h2 - 0.5f * sum;
        if (!(std::fabs(aside) < kBeside * sum) && (sum > 0 || !(std::fabs(x - 0.5f) < kBeside))) return false;
        const float across = (cx - x) * (cx - x) * length2 + sum + ch2 + both, known = nodes_[sample].distance;
        if (!(across < known * known)) return true;
        const Vec3 straight = at - source_;
        offer(sample, std::max(across, dot(straight, straight)));
        return true;
    }

    /// Marks of a sample and those beside it in its row, 8 bits each.
    [[nodiscard, gnu::always_inline]] std::uint32_t three(std::uint32_t sample) const noexcept {
        const std::uint8_t* m = marks_ + sample - 1;
        return m[0] | static_cast<std::uint32_t>(m[1]) << 8 | static_cast<std::uint32_t>(m[2]) << 16;
    }
    /// The lowest bits of three rows of three, in the order of the ring. The product moves them side by side.
    [[nodiscard, gnu::always_inline]] static std::uint32_t ring_bits(std::uint32_t beyond, std::uint32_t here,
                                                                     std::uint32_t behind) noexcept {
        static constexpr std::uint8_t kBackwards[8] = {0, 0x20, 0x10, 0x30, 0x08, 0x28, 0x18, 0x38};
        const auto packed = [](std::uint32_t bytes) { return (bytes & 0x10101u) * 0x10204u >> 16 & 7; };
        const std::uint32_t up = packed(beyond) << 7;
        return (up & 255) | up >> 8 | (here & 1) << 6 | (here >> 14 & 4) | kBackwards[packed(behind)];
    }

    /// The ring of rows.h, bit k of a byte being neighbour k, all in the grid and in no class. Only samples the front
    /// has not met get work, and those with obtuse corners: over these it can come from behind, so that a known
    /// distance may still be too long.
    void spread_inside(std::uint32_t sample) noexcept {
        static constexpr std::uint8_t kCorners[16] = {0x55, 0x57, 0x5d, 0x5f, 0x75, 0x77, 0x7d, 0x7f,
                                                      0xd5, 0xd7, 0xdd, 0xdf, 0xf5, 0xf7, 0xfd, 0xff};
        const std::uint32_t n = s_.tables.cols;
        const std::uint32_t beyond = three(sample + n), here = three(sample), behind = three(sample - n);
        std::uint32_t known = ring_bits(beyond, here, behind);
        const std::uint32_t in = kCorners[s_.ring[sample] & kRingCorners];
        const std::uint32_t obtuse =
            ((beyond | here | behind) & 0x20202) == 0 ? 0 : ring_bits(beyond >> 1, here >> 1, behind >> 1);
        known &= in;
        const std::uint32_t open = in & (~known | obtuse);
        // Neighbours whose forerunner or successor in the ring is known. A corner that is not in it is passed over.
        const std::uint32_t twice = known | known << 8, out = ~(in | in << 8);
        const std::uint32_t before = open & (twice >> 7 | (twice >> 6 & out >> 7));
        const std::uint32_t after = open & (twice >> 1 | (twice >> 2 & out >> 1));
        const Corner v = corner(sample);
        std::uint32_t alone = open & ~(known | before | after);
        std::uint32_t told = 0;
        for (std::uint32_t left = before | after << 8; left != 0; left &= left - 1) {
            const auto bit = static_cast<std::uint32_t>(__builtin_ctz(left));
            const std::uint32_t k = bit & 7, step = bit < 8 ? 7 : 1;
            const std::uint32_t next = (k + step) & 7, passed = (next + step) & 7;
            const std::uint32_t side = sample + around_[(in >> next & 1) != 0 ? next : passed];
            told |= static_cast<std::uint32_t>(through(v, corner(side), sample + around_[k])) << k;
        }
        for (; alone != 0; alone &= alone - 1) {
            const std::uint32_t to = sample + around_[__builtin_ctz(alone)];
            // The front itself comes to those it has seen.
            if (nodes_[to].distance == __builtin_inff()) along_edge(v, to);
        }
        for (std::uint32_t left = (before | after) & ~known & ~told; left != 0; left &= left - 1)
            along_edge(v, sample + around_[__builtin_ctz(left)]);
    }

    /// The same anywhere.
    [[gnu::noinline]] void spread_outside(std::uint32_t v) noexcept {
        const std::uint32_t id = s_.class_id(v);
        if (id == kNone) return spread_faces(v, v);
        for (const std::uint32_t copy : s_.members(id)) spread_faces(v, copy);
    }

    [[gnu::noinline]] void spread_face(std::uint32_t v, std::uint32_t copy, const std::uint32_t* f) noexcept {
        const int k = f[0] == copy ? 0 : f[1] == copy ? 1 : f[2] == copy ? 2 : 3;
        if (k == 3) return;
        const Corner at = corner(v);
        std::uint32_t p = s_.representative(f[(k + 1) % 3]), q = s_.representative(f[(k + 2) % 3]);
        if (p == v || q == v || p == q) return;
        bool known[2] = {(marks_[p] & kFrontKnown) != 0, (marks_[q] & kFrontKnown) != 0};
        for (const bool has : known) {
            if (!has) along_edge(at, p);
            // A known distance may still be too long: over an obtuse corner the front can come from behind.
            if (has) through(at, corner(p), q);
            std::swap(p, q);
        }
    }

    void spread_faces(std::uint32_t v, std::uint32_t copy) noexcept {
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
    std::uint8_t* const marks_;
    const std::uint32_t heads_;  ///< the first bucket's
    const ConstPlanes p_;
    const Vec3 source_;
    const float radius2_, per_bucket_;
    const float worthwhile_;   ///< shorter improvements are not worth another turn
    std::uint32_t around_[8];  ///< from a grid sample to its neighbours, in the order of rows.h
    std::uint32_t bucket_ = 0;
    std::uint32_t reopened_ = 0;  ///< bounded: crumpled surfaces could go on correcting for long
};
}  // namespace

void fill_by_front(StateImpl& s, const TableImpl& t, const Contact& c, Patch& p) noexcept {
    // The way to a sample at the rim may lead between two that are out of reach.
    constexpr float kBeyond = 1;  // mean steps
    const float reach = static_cast<float>(t.options.reach), per_step = 1 / c.step;
    Front(s, c.sample, reach * c.step + kBeyond * s.mean_step).run();
    const Weigher weigher(s, t, c);
    GeodesicScratch& g = s.geodesic;
    for (std::uint32_t k = 0; k < g.touched_count; ++k) {
        const std::uint32_t first = g.touched[k], id = s.class_id(first);
        const float d = g.nodes[first].distance * per_step;
        g.nodes[first] = {};
        g.marks[first] &= static_cast<std::uint8_t>(~kFrontKnown);
        if (!(d < reach)) continue;
        const float weight = weigher.at(first, d);
        const auto put = [&](std::uint32_t sample) {
            const std::uint32_t slot = add_cell(s, p, cell_of(s, sample)), place = place_in_cell(s, sample);
            p.cells[slot].reach |= std::uint64_t{1} << place;
            p.weights(slot)[place] = weight;
        };
        if (id == kNone)
            put(first);
        else
            for (const std::uint32_t copy : s.members(id)) put(copy);
    }
    g.touched_count = 0;
    for (std::uint32_t k = 0; k < p.count; ++k)
        if (p.cells[k].cell >= s.patch_scratch.grid_cells()) p.cells[k].touched |= p.cells[k].reach;
}

}  // namespace dgm::detail
