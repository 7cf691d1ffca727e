// SPDX-License-Identifier: MIT
// libdgm/src/contact/contact_ring.cpp
// Distances on the surface from the rim of a contact.
//
// The rim is where edges between a sample beyond the obstacle and one before it cross the obstacle's border: it moves
// steadily while samples go in and out. From there each node hands the rim point it is nearest to to its neighbours,
// across seams too; a distance is the chord to that rim point, right to fourth order while the ring is small against
// the radius of curvature (docs/methods.md section 5), and never reaches a sheet that is near in space alone.
//
// Nodes are all samples, or every fourth one of wide rings on a square domain: there the distance, negative beyond the
// rim, is bilinear between nodes, wrong by about a sixteenth of a grid step where the rim bends with a radius of 32.
// Copies of a weld class take the value of their representative.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "contact/contact_impl.h"

namespace dgm::detail {
namespace {

constexpr std::uint32_t kStride = 4;
constexpr double kWideRing = 16;  // mean steps

float square_between(Vec3 a, Vec3 b) noexcept {
    const Vec3 v = a - b;
    return v.x * v.x + v.y * v.y + v.z * v.z;
}

class Walk {
 public:
    Walk(const StateImpl& s, ContactImpl& c, float limit, std::uint32_t stride) noexcept
        : s_(s), c_(c), cols_(s.tables.cols), limit_(limit), stride_(stride) {}

    /// A rim point beside sample k: to k itself, or to the nodes around it.
    void seed(std::uint32_t k, std::uint32_t r) noexcept {
        if (stride_ == 1)
            offer(k, r);
        else
            offer_corners(k, r);
    }
    void run(std::uint32_t steps) noexcept {
        // A sample is handed on again only when its distance fell. Bounded all the same.
        std::uint64_t left = 16 * std::uint64_t{s_.total()};
        for (std::uint32_t round = count_; count_ != 0 && left-- != 0; --round) {
            if (round == 0) {
                if (--steps == 0) break;
                round = count_;
            }
            const std::uint32_t k = c_.queue[head_];
            head_ = head_ + 1 == c_.total ? 0 : head_ + 1;
            --count_;
            c_.marks[k] &= static_cast<std::uint8_t>(~kQueued);
            if (stride_ == 1)
                hand_on(k);
            else
                hand_on_nodes(k);
        }
        for (; count_ != 0; --count_) {
            c_.marks[c_.queue[head_]] &= static_cast<std::uint8_t>(~kQueued);
            head_ = head_ + 1 == c_.total ? 0 : head_ + 1;
        }
    }
    /// Signed distance at a sample, by the nodes around it; `limit` where none was reached.
    [[nodiscard, gnu::noinline]] float between(std::uint32_t i, std::uint32_t j) const noexcept {
        const std::uint32_t i0 = i - i % kStride, j0 = j - j % kStride;
        const std::uint32_t i1 = std::min(i0 + kStride, s_.tables.rows - 1), j1 = std::min(j0 + kStride, cols_ - 1);
        const float x = i1 == i0 ? 0 : static_cast<float>(i - i0) / static_cast<float>(i1 - i0);
        const float y = j1 == j0 ? 0 : static_cast<float>(j - j0) / static_cast<float>(j1 - j0);
        const float a = node(i0 * cols_ + j0), b = node(i0 * cols_ + j1), c = node(i1 * cols_ + j0),
                    d = node(i1 * cols_ + j1);
        return (1 - x) * ((1 - y) * a + y * b) + x * ((1 - y) * c + y * d);
    }
    [[nodiscard]] float signed_square(std::uint32_t k) const noexcept {
        const float d = std::min(c_.square[k], limit_);
        return (c_.marks[k] & kInside) != 0 ? -d : d;
    }
    [[nodiscard]] float node(std::uint32_t k) const noexcept {
        const float d = signed_square(k);
        return d < 0 ? -std::sqrt(-d) : std::sqrt(d);
    }

 private:
    // Most offers are rejected: the work for the others stays out of the loops.
    DGM_INLINE void offer(std::uint32_t k, std::uint32_t r) noexcept { offer(k, r, c_.rim[r]); }
    DGM_INLINE void offer(std::uint32_t k, std::uint32_t r, Vec3 rim) noexcept {
        const float d = square_between(s_.point(k), rim);
        if (d < limit_ && d < c_.square[k]) accept(k, r, d);
    }
    [[gnu::noinline]] void accept(std::uint32_t k, std::uint32_t r, float d) noexcept {
        // Nodes beyond the rim know how far it is, and keep it to themselves.
        const bool inside = (c_.marks[k] & kInside) != 0;
        if (inside && stride_ == 1) return;
        if (k < s_.tables.grid && (s_.ring[k] & kRingIrregular) == 0) return set(k, r, d, inside);
        const std::uint32_t id = s_.class_id(k);
        if (id == kNone) return set(k, r, d, inside);
        for (const std::uint32_t copy : s_.members(id)) set(copy, r, d, inside);
    }
    void offer_corners(std::uint32_t k, std::uint32_t r) noexcept {
        const std::uint32_t i = k / cols_, j = k % cols_, i0 = i - i % kStride, j0 = j - j % kStride;
        const std::uint32_t i1 = std::min(i0 + kStride, s_.tables.rows - 1), j1 = std::min(j0 + kStride, cols_ - 1);
        offer(i0 * cols_ + j0, r);
        offer(i0 * cols_ + j1, r);
        offer(i1 * cols_ + j0, r);
        offer(i1 * cols_ + j1, r);
    }
    void hand_on(std::uint32_t k) noexcept {
        const std::uint32_t r = c_.source[k];
        if (k < s_.tables.grid && (s_.ring[k] & kRingIrregular) == 0) {
            offer(k - cols_, r);
            offer(k - 1, r);
            offer(k + 1, r);
            offer(k + cols_, r);
        } else {
            each_neighbour(s_, k, [&](std::uint32_t other) { offer(other, r); });
        }
    }
    void hand_on_nodes(std::uint32_t k) noexcept {
        const std::uint32_t r = c_.source[k];
        const std::uint32_t id = (s_.ring[k] & kRingIrregular) == 0 ? kNone : s_.class_id(k);
        if (id == kNone) return around(k, r);
        for (const std::uint32_t copy : s_.members(id)) {
            around(copy, r);
            offer_corners(copy, r);  // a copy may lie between nodes
        }
    }
    void around(std::uint32_t k, std::uint32_t r) noexcept {
        const std::uint32_t i = k / cols_, j = k % cols_;
        if (i >= kStride && j >= kStride && i + kStride < s_.tables.rows && j + kStride < cols_ && i % kStride == 0 &&
            j % kStride == 0) {
            const Vec3 rim = c_.rim[r];
            for (std::uint32_t at = k - kStride * cols_; at <= k + kStride * cols_; at += kStride * cols_) {
                offer(at - kStride, r, rim);
                offer(at, r, rim);
                offer(at + kStride, r, rim);
            }
            return;
        }
        const std::uint32_t up = (i - 1) / kStride * kStride, left = (j - 1) / kStride * kStride;
        const std::uint32_t down = std::min((i / kStride + 1) * kStride, s_.tables.rows - 1);
        const std::uint32_t right = std::min((j / kStride + 1) * kStride, cols_ - 1);
        const auto row = [&](std::uint32_t at) {
            if (j > 0) offer(at * cols_ + left, r);
            if (at != i) offer(at * cols_ + j, r);
            if (right > j) offer(at * cols_ + right, r);
        };
        if (i > 0) row(up);
        row(i);
        if (down > i) row(down);
    }
    [[gnu::noinline]] void set(std::uint32_t k, std::uint32_t r, float d, bool inside) noexcept {
        if (c_.square[k] == __builtin_inff()) list(k);
        c_.square[k] = d;
        c_.source[k] = r;
        if (inside || (c_.marks[k] & kQueued) != 0) return;
        c_.marks[k] |= kQueued;
        std::uint32_t tail = head_ + count_;
        if (tail >= c_.total || tail < head_) tail -= c_.total;
        c_.queue[tail] = k;
        ++count_;
    }
    /// The tiles a newly met sample has a say in.
    void list(std::uint32_t k) noexcept {
        if (stride_ == 1) {
            c_.border = c_.border || k >= s_.tables.grid;
            return c_.add_tile(s_.tile_of(k), kTilePsi);
        }
        const std::uint32_t i = k / cols_, j = k % cols_;
        const std::uint32_t ti = StateImpl::owner(i, s_.tile_rows), tj = StateImpl::owner(j, s_.tile_cols);
        const std::uint32_t up = i == 0 ? 0 : StateImpl::owner(i - 1, s_.tile_rows);
        const std::uint32_t left = j == 0 ? 0 : StateImpl::owner(j - 1, s_.tile_cols);
        for (std::uint32_t a = up; a <= ti; ++a)
            for (std::uint32_t b = left; b <= tj; ++b) c_.add_tile(a * s_.tile_cols + b, kTilePsi);
    }

    const StateImpl& s_;
    ContactImpl& c_;
    std::uint32_t cols_;
    float limit_;
    std::uint32_t stride_;
    std::uint32_t head_ = 0, count_ = 0;
};

/// Where the edge from a sample beyond to one before the obstacle meets its border.
Vec3 crossing(const Shape& shape, Vec3 in, double in_distance, Vec3 out) noexcept {
    const double there = probe(shape, widen(out)).distance;
    const double share = there > 0 ? in_distance / (in_distance - there) : 1;
    const double part = std::clamp(share, 0.0, 1.0);
    return narrow(widen(in) + part * (widen(out) - widen(in)));
}

void seed_rim(const StateImpl& s, ContactImpl& c, const Shape& shape, Walk& walk) noexcept {
    const std::uint32_t cols = s.tables.cols, phi_tiles = c.tile_count;  // the walk appends its own
    c.rim_count = 0;
    const auto seed = [&](std::uint32_t k) {
        double distance = 1;
        each_neighbour(s, k, [&](std::uint32_t other) {
            if ((c.marks[other] & kInside) != 0 || c.rim_count == c.rim.size()) return;
            if (distance > 0) distance = std::min(probe(shape, widen(s.point(k))).distance, 0.0);
            c.rim[c.rim_count] = crossing(shape, s.point(k), distance, s.point(other));
            walk.seed(other, c.rim_count++);
        });
    };
    for (std::uint32_t e = 0; e < phi_tiles; ++e) {
        const Rect r = c.rects[c.tiles[e]];
        // Off the grid's border and off seams whole rows of a tile show at once that they have no rim.
        const bool even = !s.tables.free_domain && s.tables.mask == nullptr && r.width() == 8 && r.i0 != 0 &&
                          r.j0 != 0 && r.i1 + 1 < s.tables.rows && (s.tile_flags[c.tiles[e]] & kTileSpecial) == 0;
        const auto eight = [&](std::uint32_t k) {
            std::uint64_t marks;
            std::memcpy(&marks, c.marks.data() + k, 8);
            return marks & 0x0101010101010101 * kInside;
        };
        for (std::uint32_t i = r.i0; i <= r.i1; ++i) {
            const std::uint32_t first = i * cols + r.j0;
            const std::uint64_t row = even ? eight(first) : 1;
            if (row == 0 || (even && (row & ~(eight(first - cols) & eight(first - 1) & eight(first + 1) &
                                              eight(first + cols))) == 0))
                continue;
            for (std::uint32_t k = first; k <= i * cols + r.j1; ++k) {
                if ((c.marks[k] & kInside) == 0) continue;
                if ((s.ring[k] & kRingIrregular) == 0 &&
                    (c.marks[k - cols] & c.marks[k - 1] & c.marks[k + 1] & c.marks[k + cols] & kInside) != 0)
                    continue;
                seed(k);
            }
        }
    }
    if (c.border)
        for (std::uint32_t k = s.tables.grid; k < s.total(); ++k)
            if ((c.marks[k] & kInside) != 0) seed(k);
}

/// Squared distances of all samples of the tile into c.weight. @return whether a copy of one lies in a tile that was
/// listed for other reasons: it has to be filled now as well.
bool fill_tile(const StateImpl& s, ContactImpl& c, const Walk& walk, float limit, std::uint32_t tile) noexcept {
    const std::uint32_t cols = s.tables.cols;
    const auto squared = [](float d) { return d > 0 ? d * d : 0; };
    const Rect r = c.rects[tile];
    if (r.i0 + 8 < s.tables.rows && r.j0 + 8 < cols) {
        const std::uint32_t first = r.i0 * cols + r.j0;
        SpreadJob job{{}, c.marks.data() + first, c.weight.data() + first, cols};
        for (std::uint32_t a = 0; a < 9; ++a)
            job.nodes[a] = walk.signed_square(first + kStride * (a / 3 * cols + a % 3));
        c.rows_of->spread(job);
    }
    // The rest of the last row and column of tiles.
    for (std::uint32_t i = r.i0; i <= r.i1; ++i)
        for (std::uint32_t j = i < r.i0 + 8 && r.i0 + 8 < s.tables.rows && r.j0 + 8 < cols ? r.j0 + 8 : r.j0;
             j <= r.j1;) {
            // Four samples between two columns of nodes: along a row the distance is linear.
            const std::uint32_t last = std::min((j / kStride + 1) * kStride, cols - 1);
            const std::uint32_t end = std::min(last, r.j1 + 1);
            const float from = walk.between(i, j), to = walk.between(i, last);
            const float slope = last == j ? 0 : (to - from) / static_cast<float>(last - j);
            for (std::uint32_t q = j; q < std::max(end, j + 1); ++q) {
                const std::size_t k = std::size_t{i} * cols + q;
                const float d = squared(from + slope * static_cast<float>(q - j));
                c.weight[k] = (c.marks[k] & kInside) != 0 ? __builtin_inff() : d;
            }
            j = std::max(end, j + 1);
        }
    bool more = false;
    if ((s.tile_flags[tile] & kTileSpecial) == 0) return more;
    for (std::uint32_t i = r.i0; i <= r.i1; ++i)
        for (std::uint32_t k = i * cols + r.j0; k <= i * cols + r.j1; ++k) {
            if (c.in_class[k] == 0 || (c.marks[k] & kInside) != 0) continue;
            const std::uint32_t first = s.representative(k);
            const float d = squared(walk.between(first / cols, first % cols));
            c.weight[k] = d;
            if (!(d < limit)) continue;
            for (const std::uint32_t copy : s.members(s.class_id(k))) {
                const std::uint8_t bits = c.tile_bits[s.tile_of(copy)];
                more = more || (bits != 0 && (bits & kTilePsi) == 0);
                c.add_tile(s.tile_of(copy), kTilePsi);
            }
        }
    return more;
}

/// The same of all tiles of the ring, which grows by those of copies.
void fill_between(const StateImpl& s, ContactImpl& c, const Walk& walk, float limit) noexcept {
    for (bool more = true; more;) {
        more = false;
        for (std::uint32_t e = 0; e < c.tile_count; ++e) {
            const std::uint32_t tile = c.tiles[e];
            if ((c.tile_bits[tile] & (kTilePsi | kTileSpread)) != kTilePsi) continue;
            c.tile_bits[tile] |= kTileSpread;
            more = fill_tile(s, c, walk, limit, tile) || more;
        }
    }
}
}  // namespace

void grow_ring(const StateImpl& s, ContactImpl& c, const Shape& shape, double reach, std::uint32_t steps) noexcept {
    const float limit = static_cast<float>(reach * reach);
    const bool wide = c.closed && !s.tables.free_domain && s.tables.mask == nullptr && s.total() == s.tables.grid &&
                      reach > kWideRing * double{s.mean_step};
    Walk walk(s, c, limit, wide ? kStride : 1);
    seed_rim(s, c, shape, walk);
    walk.run(steps);
    c.spread = wide;
    if (wide) fill_between(s, c, walk, limit);
}

}  // namespace dgm::detail
