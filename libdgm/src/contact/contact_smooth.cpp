// SPDX-License-Identifier: MIT
// libdgm/src/contact/contact_smooth.cpp
// Open surfaces have no volume to keep: instead of a bulge the displacement fades into the ring.
#include <cstring>

#include "contact/contact_impl.h"

namespace dgm::detail {
namespace {

class Smoother {
 public:
    Smoother(StateImpl& s, ContactImpl& c, const Shape& shape) noexcept : s_(s), c_(c), shape_(shape) {}

    void run(std::uint32_t rounds) noexcept {
        each([&](std::uint32_t k) {
            const bool inside = (c_.marks[k] & kInside) != 0;
            c_.queue[k] = inside && shape_.kind == ObstacleKind::Surface ? c_.source[k] : kNone;
            if (inside || c_.square[k] < __builtin_inff()) c_.marks[k] |= kMember;
        });
        for (std::uint32_t r = 0; r < rounds; ++r) {
            last_ = r + 1 == rounds;
            // All averages of the round before any is used: the order of samples does not show.
            each_tile_of([&](std::uint32_t tile) { average_tile(tile); });
            each_border([&](std::uint32_t k) { average_sample(k); });
            each_tile_of([&](std::uint32_t tile) {
                look_into(shape_, s_.now_boxes.boxes[tile]);
                place_tile(tile);
            });
            each_border([&](std::uint32_t k) {
                if ((c_.marks[k] & kMoving) != 0) place(k);
            });
        }
    }

 private:
    /// Tiles that hold members.
    template <class F>
    void each_tile_of(F f) const noexcept {
        for (std::uint32_t e = 0; e < c_.tile_count; ++e)
            if ((c_.tile_bits[c_.tiles[e]] & (kTilePhi | kTilePsi)) != 0) f(c_.tiles[e]);
    }
    template <class F>
    void each_border(F f) const noexcept {
        if (c_.border)
            for (std::uint32_t k = s_.tables.grid; k < s_.total(); ++k) f(k);
    }
    template <class F>
    void each(F f) const noexcept {
        each_tile_of([&](std::uint32_t tile) { each_sample(c_.rects[tile], f); });
        each_border(f);
    }
    template <class F>
    void each_sample(const Rect& r, F f) const noexcept {
        for (std::uint32_t i = r.i0; i <= r.i1; ++i)
            for (std::uint32_t k = i * s_.tables.cols + r.j0; k <= i * s_.tables.cols + r.j1; ++k) f(k);
    }
    /// Eight bytes in a row, as the loops below test them.
    [[nodiscard]] static std::uint64_t eight(const std::uint8_t* bytes) noexcept {
        std::uint64_t word;
        std::memcpy(&word, bytes, 8);
        return word;
    }
    [[nodiscard]] bool is_regular(const Rect& r) const noexcept {
        if (r.width() != 8) return false;
        std::uint64_t any = 0;
        for (std::uint32_t i = r.i0; i <= r.i1; ++i)
            any |= eight(s_.ring.data() + std::size_t{i} * s_.tables.cols + r.j0);
        return (any & 0x0101010101010101 * kRingIrregular) == 0;
    }
    void average_tile(std::uint32_t tile) noexcept {
        const Rect r = c_.rects[tile];
        if (!is_regular(r)) return each_sample(r, [&](std::uint32_t k) { average_sample(k); });
        c_.rows_of->smooth({r, s_.tables.cols, StateImpl::fixed(s_.now), StateImpl::fixed(c_.before()),
                            s_.mobility.empty() ? nullptr : s_.mobility.data(), c_.marks.data(), c_.square.data(),
                            c_.weight.data(), c_.source.data()});
    }
    void average_sample(std::uint32_t k) noexcept {
        c_.marks[k] &= static_cast<std::uint8_t>(~kMoving);
        if (!moves(k)) return;
        const Double3 d = average(k);
        keep(k, d);
        // Displacements come a step a round from the contact: most of the ring has none yet, and stays.
        const auto is_none = [](Vec3 v) { return v.x == 0 && v.y == 0 && v.z == 0; };
        const bool still = is_none(narrow(d)) && is_none(s_.point(k) - StateImpl::at(c_.before(), k));
        if (!still || (c_.marks[k] & kInside) != 0) c_.marks[k] |= kMoving;
    }
    void place_tile(std::uint32_t tile) noexcept {
        const Rect r = c_.rects[tile];
        for (std::uint32_t i = r.i0; i <= r.i1; ++i) {
            const std::uint32_t first = i * s_.tables.cols + r.j0;
            if (r.width() == 8 && (eight(c_.marks.data() + first) & 0x0101010101010101 * kMoving) == 0) continue;
            for (std::uint32_t k = first; k < first + r.width(); ++k)
                if ((c_.marks[k] & kMoving) != 0) place(k);
        }
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
