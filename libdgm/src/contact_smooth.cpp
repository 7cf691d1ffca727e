// SPDX-License-Identifier: MIT
// libdgm/src/contact_smooth.cpp
// Open surfaces have no volume to keep: instead of a bulge the displacement fades into the ring.
#include "contact_impl.h"

namespace dgm::detail {
namespace {

class Smoother {
 public:
    Smoother(StateImpl& s, ContactImpl& c, const Shape& shape) noexcept : s_(s), c_(c), shape_(shape) {}

    void run(std::uint32_t rounds) noexcept {
        each([&](std::uint32_t k) {
            const bool inside = (c_.marks[k] & kInside) != 0;
            if (!inside) c_.queue[k] = kNone;
            if (inside || c_.square[k] < __builtin_inff()) c_.marks[k] |= kMember;
        });
        for (std::uint32_t r = 0; r < rounds; ++r) {
            last_ = r + 1 == rounds;
            // All averages of the round before any is used: the order of samples does not show.
            each([&](std::uint32_t k) {
                if (moves(k)) keep(k, average(k));
            });
            each([&](std::uint32_t k) {
                if (moves(k)) place(k);
            });
        }
    }

 private:
    template <class F>
    void each(F f) const noexcept {
        for (std::uint32_t e = 0; e < c_.tile_count; ++e) {
            const Rect r = s_.tile_rect(c_.tiles[e]);
            look_into(shape_, s_.now_boxes.boxes[c_.tiles[e]]);
            for (std::uint32_t i = r.i0; i <= r.i1; ++i)
                for (std::uint32_t k = i * s_.tables.cols + r.j0; k <= i * s_.tables.cols + r.j1; ++k) f(k);
        }
        if (c_.border)
            for (std::uint32_t k = s_.tables.grid; k < s_.total(); ++k) f(k);
    }
    /// Classes are computed once, at their representative.
    [[nodiscard]] bool moves(std::uint32_t k) const noexcept {
        return (c_.marks[k] & kMember) != 0 && s_.representative(k) == k;
    }
    [[nodiscard]] Double3 displacement(std::uint32_t k) const noexcept {
        if ((c_.marks[k] & kMember) == 0) return {};
        return widen(s_.point(k)) - widen(StateImpl::at(c_.before(), k));
    }
    [[nodiscard]] Double3 average(std::uint32_t k) const noexcept {
        Double3 sum;
        double count = 0;
        const auto add = [&](std::uint32_t other) {
            sum = sum + displacement(other);
            ++count;
        };
        const std::uint32_t cols = s_.tables.cols;
        if (k < s_.tables.grid && (s_.ring[k] & kRingIrregular) == 0)
            for (const std::uint32_t other : {k - cols, k - 1, k + 1, k + cols}) add(other);
        else
            each_neighbour(s_, k, add);
        const double m = mobility_of(s_, k);
        return count == 0 ? displacement(k) : m * (0.5 * displacement(k) + (0.5 / count) * sum);
    }
    // The ring's scratch is free by now.
    void keep(std::uint32_t k, Double3 d) noexcept {
        const Vec3 v = narrow(d);
        c_.square[k] = v.x;
        c_.weight[k] = v.y;
        c_.source[k] = __builtin_bit_cast(std::uint32_t, v.z);
    }
    void place(std::uint32_t k) noexcept {
        const Vec3 d{c_.square[k], c_.weight[k], __builtin_bit_cast(float, c_.source[k])};
        Double3 p = widen(StateImpl::at(c_.before(), k) + d);
        // Displacements come a step a round from the contact: most of the ring has none yet, and stays.
        const auto is_none = [](Vec3 v) { return v.x == 0 && v.y == 0 && v.z == 0; };
        if (is_none(d) && (c_.marks[k] & kInside) == 0 && is_none(s_.point(k) - StateImpl::at(c_.before(), k))) return;
        // On the way the plane of the facet that was nearest will do; it is the last round that must be right.
        const bool exact = last_ || shape_.kind != ObstacleKind::Surface || c_.queue[k] == kNone;
        if (!exact || !(around_.clearance(shape_, p) > 0)) {
            const Probe there = exact ? probe(shape_, p) : facet_probe(shape_, c_.queue[k], p);
            if (exact) around_.note(p, there.distance);
            c_.queue[k] = there.facet;
            if (there.distance < 0) p = p + double{mobility_of(s_, k)} * (there.nearest - p);
        }
        const Vec3 v = narrow(p);
        const auto put = [&](std::uint32_t at) {
            s_.now.x[at] = v.x;
            s_.now.y[at] = v.y;
            s_.now.z[at] = v.z;
        };
        const std::uint32_t id = s_.class_id(k);
        if (id == kNone) return put(k);
        for (const std::uint32_t copy : s_.members(id)) put(copy);
    }
    StateImpl& s_;
    ContactImpl& c_;
    const Shape& shape_;
    Surroundings around_;
    bool last_ = false;
};
}  // namespace

void smooth_contact(StateImpl& s, ContactImpl& c, const Shape& shape, std::uint32_t rounds) noexcept {
    if (rounds != 0) Smoother(s, c, shape).run(rounds);
}

}  // namespace dgm::detail
