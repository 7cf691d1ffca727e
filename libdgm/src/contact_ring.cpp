// SPDX-License-Identifier: MIT
// libdgm/src/contact_ring.cpp
// Distances on the surface from the rim of a contact.
//
// The rim is where edges between a sample beyond the obstacle and one before it cross the obstacle's border: it moves
// steadily while samples go in and out. From there each sample hands the rim point it is nearest to to its neighbours,
// across seams too; a distance is the chord to that rim point, right to fourth order while the ring is small against
// the radius of curvature (methods section 5), and never reaches a sheet that is near in space alone.
#include <algorithm>
#include <cmath>

#include "contact_impl.h"

namespace dgm::detail {
namespace {

float square_between(Vec3 a, Vec3 b) noexcept {
    const Vec3 v = a - b;
    return v.x * v.x + v.y * v.y + v.z * v.z;
}

class Walk {
 public:
    Walk(const StateImpl& s, ContactImpl& c, float limit) noexcept : s_(s), c_(c), limit_(limit) {}

    /// Offers rim point r to a sample and its copies.
    void offer(std::uint32_t k, std::uint32_t r) noexcept {
        if ((c_.marks[k] & kInside) != 0) return;
        const float d = square_between(s_.point(k), c_.rim[r]);
        if (!(d < limit_) || !(d < c_.square[k])) return;
        if (k < s_.tables.grid && (s_.ring[k] & kRingIrregular) == 0) return set(k, r, d);
        const std::uint32_t id = s_.class_id(k);
        if (id == kNone) return set(k, r, d);
        for (const std::uint32_t copy : s_.members(id)) set(copy, r, d);
    }
    void run() noexcept {
        // A sample is handed on again only when its distance fell. Bounded all the same.
        std::uint64_t left = 16 * std::uint64_t{s_.total()};
        while (count_ != 0 && left-- != 0) {
            const std::uint32_t k = c_.queue[head_];
            head_ = head_ + 1 == c_.total ? 0 : head_ + 1;
            --count_;
            c_.marks[k] &= static_cast<std::uint8_t>(~kQueued);
            const std::uint32_t r = c_.source[k];
            if (k < s_.tables.grid && (s_.ring[k] & kRingIrregular) == 0) {
                offer(k - s_.tables.cols, r);
                offer(k - 1, r);
                offer(k + 1, r);
                offer(k + s_.tables.cols, r);
            } else {
                each_neighbour(s_, k, [&](std::uint32_t other) { offer(other, r); });
            }
        }
        for (; count_ != 0; --count_) {
            c_.marks[c_.queue[head_]] &= static_cast<std::uint8_t>(~kQueued);
            head_ = head_ + 1 == c_.total ? 0 : head_ + 1;
        }
    }

 private:
    void set(std::uint32_t k, std::uint32_t r, float d) noexcept {
        if (std::isinf(c_.square[k])) {
            c_.add_tile(s_.tile_of(k), kTilePsi);
            c_.border = c_.border || k >= s_.tables.grid;
        }
        c_.square[k] = d;
        c_.source[k] = r;
        if ((c_.marks[k] & kQueued) != 0) return;
        c_.marks[k] |= kQueued;
        std::uint32_t tail = head_ + count_;
        if (tail >= c_.total || tail < head_) tail -= c_.total;
        c_.queue[tail] = k;
        ++count_;
    }
    const StateImpl& s_;
    ContactImpl& c_;
    float limit_;
    std::uint32_t head_ = 0, count_ = 0;
};

/// Where the edge from a sample beyond to one before the obstacle meets its border.
Vec3 crossing(const Shape& shape, Vec3 in, double in_distance, Vec3 out) noexcept {
    const double there = probe(shape, widen(out)).distance;
    const double share = there > 0 ? in_distance / (in_distance - there) : 1;
    const double part = std::clamp(share, 0.0, 1.0);
    return narrow(widen(in) + part * (widen(out) - widen(in)));
}
}  // namespace

void grow_ring(const StateImpl& s, ContactImpl& c, const Shape& shape, double reach) noexcept {
    c.rim_count = 0;
    Walk walk(s, c, static_cast<float>(reach * reach));
    const auto seed = [&](std::uint32_t k) {
        double distance = 1;
        each_neighbour(s, k, [&](std::uint32_t other) {
            if ((c.marks[other] & kInside) != 0 || c.rim_count == c.rim.size()) return;
            if (distance > 0) distance = std::min(probe(shape, widen(s.point(k))).distance, 0.0);
            c.rim[c.rim_count] = crossing(shape, s.point(k), distance, s.point(other));
            walk.offer(other, c.rim_count++);
        });
    };
    const std::uint32_t cols = s.tables.cols;
    const std::uint32_t phi_tiles = c.tile_count;  // the walk appends its own
    for (std::uint32_t e = 0; e < phi_tiles; ++e) {
        const Rect r = s.tile_rect(c.tiles[e]);
        for (std::uint32_t i = r.i0; i <= r.i1; ++i)
            for (std::uint32_t k = i * cols + r.j0; k <= i * cols + r.j1; ++k) {
                if ((c.marks[k] & kInside) == 0) continue;
                if ((s.ring[k] & kRingIrregular) == 0 &&
                    (c.marks[k - cols] & c.marks[k - 1] & c.marks[k + 1] & c.marks[k + cols] & kInside) != 0)
                    continue;
                seed(k);
            }
    }
    if (c.border)
        for (std::uint32_t k = s.tables.grid; k < s.total(); ++k)
            if ((c.marks[k] & kInside) != 0) seed(k);
    walk.run();
}

}  // namespace dgm::detail
