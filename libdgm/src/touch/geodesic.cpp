// SPDX-License-Identifier: MIT
// libdgm/src/touch/geodesic.cpp
// Distances on the rest surface around a sample, by windows that run outwards over the welded triangles.
//
// [Chen, Han 1990] Shortest paths on a polyhedron. SoCG 1990.
// [Xin, Wang 2009] Improving Chen and Han's algorithm on the discrete geodesic problem. ACM TOG 28(4).
// A window holds straight lines from one source through an edge. Crossing a triangle it measures the corner beyond and
// splits there; corners that bend shortest ways become sources of their own [Chen, Han]. A window whose points are
// nearer by way of a corner is left out [Xin, Wang]. This alone is exact; joining windows (window_queue.h) costs up to
// 1.6 % of the peak of a weight, measured on sixteen surfaces from organs to an octopus.
#include <algorithm>
#include <cmath>
#include <span>

#include "touch/patch.h"
#include "touch/state_impl.h"
#include "touch/table_impl.h"
#include "touch/unfolding.h"
#include "touch/window_queue.h"

namespace dgm::detail {
namespace {

/// Squared share of its distance by which a corner must be nearer than a window has it: joined windows are not exact.
constexpr float kBehind = 0.96f;
/// Triangles around a corner that are looked at where it bends ways.
constexpr int kMostAround = 64;
/// Windows that are followed at most. Organs need 4 a sample, the wildest surfaces 15.
constexpr std::uint32_t kWindows = 4096, kWindowsASample = 64;
/// How far ways along edges lead at most from where windows went.
constexpr int kMostRounds = 64;

/// A triangle seen from one of its corners, in a plane with that corner at the origin: the edge by which it is entered,
/// as in Window, with the corner at its left end (hand 0: around the right of it) or right end (1).
struct Turn {
    Way way = kNone;  ///< kNone: an open border
    Vec2 a{}, e{};
    Vec2 apex{};  ///< the third corner
};

/// Everything between v and `far` is nearer by way of v [Xin, Wang 2009, section 3.3].
[[nodiscard]] DGM_INLINE bool is_behind(float known, Vec2 v, Vec2 far, float offset) noexcept {
    return known + length(far - v) < offset + length(far);
}

class Fan {
 public:
    /// Lengths in steps. Distances go to FootprintScratch::key.
    Fan(StateImpl& s, float radius, float per_step) noexcept
        : s_(s),
          g_(s.geodesic),
          surface_(s, per_step),
          corners_(g_.corners.data()),
          distance_(s.footprint.key.data()),
          touched_(s.footprint.samples.data()),
          cols_(s.tables.cols),
          radius_(radius),
          per_step_(per_step),
          queue_(g_, radius) {}

    void run(std::uint32_t source) noexcept {
        static_cast<void>(offer(source, 0));
        surface_.each_triangle_at(source, [&](const Across& at) { start(source, at); });
        Window w;
        for (std::uint32_t count = 0; queue_.take(w); ++count) {
            if (count > kWindows + kWindowsASample * count_) {
                complete_ = false;
                break;
            }
            if ((w.way & kBend) == 0)
                cross_triangle(w);
            else
                bend(w);
        }
        if (find_missed()) go_along_edges();
    }
    /// Representatives with a distance.
    [[nodiscard]] std::span<const std::uint32_t> touched() const noexcept { return {touched_, count_}; }

 private:
    /// A way of length d to v. @return whether it is the shortest so far.
    DGM_INLINE bool offer(std::uint32_t v, float d) noexcept {
        if (!(d < distance_[v]) || !(d <= radius_)) return false;
        if (distance_[v] == __builtin_inff()) touched_[count_++] = v;
        distance_[v] = d;
        return true;
    }

    /// A triangle at the contact.
    void start(std::uint32_t source, const Across& in) noexcept {
        const std::uint32_t left = surface_.corner(in.end(1));
        const Vec3 at = StateImpl::at(s_.rest, source);
        const Vec3 e = per_step_ * (StateImpl::at(s_.rest, left) - at);
        const Vec3 f = per_step_ * (StateImpl::at(s_.rest, in.apex()) - at);
        const float d = std::sqrt(dgm::dot(e, e)), far = std::sqrt(dgm::dot(f, f));
        const bool fresh = offer(left, d);
        if (!(far > 0)) return;
        // The plane: the contact, the apex to the right, the left end.
        const float x = dgm::dot(e, f) / far;
        const Vec3 h = e - (x / far) * f;
        const Vec2 a{far, 0}, b{x, std::sqrt(dgm::dot(h, h))};
        if (fresh) bend_later(left, in.own(0) ^ 1u, a - b, -a, b, d);
        // The triangle comes twice: mirrored it is the same.
        if (in.end(1) > in.apex()) push(in, 1, a, b - a, dot(a, a), 0, 1, 0);
    }

    /// Lines that cross the edge from a to a + e between right and left go on. Through an edge that is short beside
    /// another side of the triangle none do: what is beyond lies beside its ends.
    DGM_INLINE void push(const Across& at, int hand, Vec2 a, Vec2 e, float side2, float right, float left,
                         float offset) noexcept {
        const float room = radius_ - offset, room2 = room * room;
        const Vec2 r = a + right * e, l = a + left * e;
        if (!(left > right) || Unfolding::is_short(e, side2)) return;
        if (!(dot(r, r) < room2) && !(dot(l, l) < room2)) {
            // Both ends are out of reach: is the middle?
            const float area = cross(a, e), e2 = dot(e, e);
            if (!(dot(r, e) < 0) || !(dot(l, e) > 0) || !(area * area < room2 * e2)) return;
        }
        const Window w{a.x, a.y, e.x, e.y, right, left, offset, at.out(hand), kNone};
        if (!at.loose) [[likely]]
            complete_ &= queue_.put(w);
        else
            push_loose(w, at, hand);
    }
    [[gnu::noinline]] void push_loose(Window w, const Across& at, int hand) noexcept {
        surface_.each_beyond(at, hand, [&](Way way) {
            w.way = way;
            complete_ &= queue_.put(w);
        });
    }

    void cross_triangle(const Window& w) noexcept {
        const Across in = surface_.across(w.way);
        const Vec2 a{w.ax, w.ay}, e{w.ex, w.ey}, ac = surface_.to_third(in, e), c = a + ac, cb = e - ac;
        const std::uint32_t v = surface_.corner(in.apex());
        const float known = distance_[v], room = known - w.offset, c2 = dot(c, c), e2 = dot(e, e);
        // The line to c crosses the edge at `at`.
        const float area = cross(a, e), whole = area - cross(e, ac), at = cross(a, ac) / whole;
        const float right = (at - w.right) * whole, left = (w.left - at) * whole;
        if (room > 0 && room * room > c2) {
            // Straight, or around the outermost line.
            const Vec2 over = a + std::min(w.left, std::max(w.right, at)) * e, ray = c - over;
            const float d = w.offset + length(over) + length(ray);
            if (offer(v, d)) bend_later(v, w.way, a - c, e, right >= 0 && left >= 0 ? c : ray, d);
        }
        const bool behind = !(room > 0) || room * room < kBehind * c2;
        if (right > 0) {  // lines to the right of c
            const float from = w.right > 0 ? w.right * area / (w.right * area + right) : 0;
            const float to = left > 0 ? 1 : w.left * area / (w.left * area - left);
            if (!behind || !is_behind(known, c, a + from * ac, w.offset)) push(in, 0, a, ac, e2, from, to, w.offset);
        }
        if (left > 0) {
            const float from = right > 0 ? 0 : right / (right - (1 - w.right) * area);
            const float to = w.left < 1 ? left / (left + (1 - w.left) * area) : 1;
            if (!behind || !is_behind(known, c, c + to * cb, w.offset)) push(in, 1, c, cb, e2, from, to, w.offset);
        }
    }

    /// Corner v was reached along `ray`, over a triangle that was entered at the edge from a to a + e as seen from v.
    DGM_INLINE void bend_later(std::uint32_t v, Way way, Vec2 a, Vec2 e, Vec2 ray, float d) noexcept {
        if ((corners_[v] & kCornerBends) == 0) return;
        complete_ &= queue_.put_at(d, {a.x, a.y, e.x, e.y, ray.x, ray.y, d, way | kBend, kNone});
    }
    /// A corner becomes a source for the region between the ways straight on around its right and around its left.
    [[gnu::noinline]] void bend(const Window& w) noexcept {
        const Across in = surface_.across(w.way & ~kBend);
        const float d = w.offset;
        if (distance_[surface_.corner(in.apex())] != d) return;  // there was a shorter way
        const Vec2 a{w.ax, w.ay}, b = a + Vec2{w.ex, w.ey}, ray{w.right, w.left};
        const Turn on[2] = {straight_on(turn(in, 0, a, -a), ray, 0), straight_on(turn(in, 1, {0, 0}, b), ray, 1)};
        if (on[0].way == kNone && on[1].way == kNone) return;
        const std::uint32_t end = on[1].way == kNone ? kNone : surface_.across(on[1].way).own(1) >> 1;
        const bool met = on[0].way != kNone && shine(on[0], 0, ray, d, end, on[1]);
        // An open border on the way to the other side: what is between that and the border is still to come.
        if (!met && on[1].way != kNone) shine(on[1], 1, ray, d, kNone, on[1]);
    }
    /// Lines from a corner into the triangles around it, from the one that a way straight on goes into, until that of
    /// the other side, `far`, which is entered at `end`. @return whether it was met
    [[gnu::noinline]] bool shine(Turn t, int hand, Vec2 ray, float d, std::uint32_t end, const Turn& far) noexcept {
        float begin = meet(ray, facing(t, hand));
        for (int k = 0; t.way != kNone && k < kMostAround; ++k) {
            const Across at = surface_.across(t.way);
            const Facing f = facing(t, hand);
            const bool last = at.own(hand) >> 1 == end;
            const float finish = last ? meet(ray, facing(far, 1)) : hand == 0 ? 1.0f : 0.0f;
            push(at, hand, f.a, f.e, dot(f.a, f.a), hand == 0 ? begin : finish, hand == 0 ? finish : begin, d);
            if (last) return true;
            begin = 1 - finish;
            const std::uint32_t apex = surface_.corner(at.apex());
            const float along = length(t.apex);
            if (offer(apex, d + along)) bend_later(apex, t.way, t.a - t.apex, t.e, t.apex, d + along);
            t = next(t, at, hand);
        }
        return false;
    }
    /// The triangle beyond an edge of another; the corner that is turned around is at the origin.
    [[nodiscard]] Turn turn(const Across& at, int hand, Vec2 a, Vec2 e) const noexcept {
        Turn t;
        if (!at.loose)
            t.way = at.out(hand);
        else
            surface_.each_beyond(at, hand, [&](Way way) { t.way = way; });
        if (t.way == kNone) return t;
        t.a = a;
        t.e = e;
        t.apex = a + surface_.to_third(surface_.across(t.way), e);
        return t;
    }
    /// The next triangle around the corner.
    [[nodiscard]] Turn next(const Turn& t, const Across& at, int hand) const noexcept {
        return hand == 0 ? turn(at, 1, t.apex, -t.apex) : turn(at, 0, {0, 0}, t.apex);
    }
    /// The triangle around a corner into which a line goes straight on along `ray`, half a turn from where it came.
    [[nodiscard]] Turn straight_on(Turn t, Vec2 ray, int hand) const noexcept {
        for (int k = 0; t.way != kNone && k < kMostAround; ++k) {
            if ((hand == 0 ? cross(ray, t.apex) : cross(t.apex, ray)) > 0) return t;
            t = next(t, surface_.across(t.way), hand);
        }
        return {};
    }
    /// The edge opposite to the corner that a turn is around, from its right end.
    struct Facing {
        Vec2 a, e;
    };
    [[nodiscard]] static Facing facing(const Turn& t, int hand) noexcept {
        return hand == 0 ? Facing{t.a, t.apex - t.a} : Facing{t.apex, t.e - t.apex};
    }
    /// Where the line along `ray` crosses it.
    [[nodiscard]] static float meet(Vec2 ray, const Facing& f) noexcept {
        const float k = cross(f.a, ray) / cross(ray, f.e);
        return k > 0 ? std::min(k, 1.0f) : 0;
    }

    /// Marks samples beside one that has no distance and should have one, since joined windows can leave gaps where the
    /// surface is a saddle; ends of short edges; all if some windows were not followed. @return whether there are any.
    [[nodiscard]] bool find_missed() noexcept {
        const std::uint32_t beside[4] = {1, cols_ + 1, cols_, cols_ - 1};
        bool any = !complete_;
        for (const std::uint32_t v : touched()) {
            bool missed = !complete_ || (corners_[v] & kCornerShort) != 0;
            if (!missed && v < s_.tables.grid && (s_.ring[v] & kRingIrregular) == 0) {
                float sum = 0;
                for (const std::uint32_t d : beside) sum += distance_[v + d] + distance_[v - d];
                if (!(sum < __builtin_inff()))
                    for (const std::uint32_t d : beside) missed = missed || is_missed(v, v + d) || is_missed(v, v - d);
            } else if (!missed) {
                surface_.each_triangle_at(v, [&](const Across& in) { missed = missed || is_missed(v, in.end(1)); });
            }
            if (missed) corners_[v] |= kCornerChanged;
            any = any || missed;
        }
        return any;
    }
    [[nodiscard]] bool is_missed(std::uint32_t v, std::uint32_t beside) const noexcept {
        return distance_[surface_.corner(beside)] == __builtin_inff() && distance_[v] + span(v, beside) < radius_;
    }
    /// The straight line between two samples, in steps.
    [[nodiscard]] float span(std::uint32_t a, std::uint32_t b) const noexcept {
        const Vec3 e = per_step_ * (StateImpl::at(s_.rest, b) - StateImpl::at(s_.rest, a));
        return std::sqrt(dgm::dot(e, e));
    }
    /// Shorter ways along edges from the samples that are marked, and from those they lead to.
    [[gnu::noinline]] void go_along_edges() noexcept {
        bool changed = true;
        for (int round = 0; changed; ++round) {
            changed = false;
            for (std::uint32_t k = 0; k < count_; ++k) {
                const std::uint32_t from = touched_[k];
                if ((corners_[from] & kCornerChanged) == 0) continue;
                corners_[from] &= static_cast<std::uint8_t>(~kCornerChanged);
                if (round == kMostRounds) continue;
                surface_.each_triangle_at(from, [&](const Across& in) {
                    const std::uint32_t v = surface_.corner(in.end(1));
                    if (!offer(v, distance_[from] + span(from, v))) return;
                    corners_[v] |= kCornerChanged;
                    changed = true;
                });
            }
        }
    }

    StateImpl& s_;
    GeodesicScratch& g_;
    const Unfolding surface_;
    std::uint8_t* const corners_;
    float* const distance_;
    std::uint32_t* const touched_;
    const std::uint32_t cols_;
    const float radius_, per_step_;
    std::uint32_t count_ = 0;  ///< touched
    bool complete_ = true;     ///< no window was left out for want of room or time
    WindowQueue queue_;
};

struct Place {
    std::uint32_t cell, place;
};
/// cell_of() and place_in_cell() with one division.
Place place_of(const StateImpl& s, std::uint32_t sample) noexcept {
    if (sample >= s.tables.grid) return {cell_of(s, sample), place_in_cell(s, sample)};
    const std::uint32_t i = sample / s.tables.cols, j = sample - i * s.tables.cols;
    return {(i >> 3) * s.patch_scratch.cols + (j >> 3), (i & 7) * 8 + (j & 7)};
}
}  // namespace

void fill_by_front(StateImpl& s, const TableImpl& t, const Contact& c, Patch& p) noexcept {
    const float reach = static_cast<float>(t.options.reach);
    Fan fan(s, reach, 1 / c.step);
    fan.run(s.representative(c.sample));
    const Weigher weigher(s, t, c);
    for (const std::uint32_t first : fan.touched()) {
        const std::uint32_t id = s.class_id(first);
        const float d = s.footprint.key[first];
        s.footprint.key[first] = __builtin_inff();
        if (!(d < reach)) continue;
        const float weight = weigher.at(first, d);
        const auto put = [&](std::uint32_t sample) {
            const Place at = place_of(s, sample);
            const std::uint32_t known = s.patch_scratch.slot_of[at.cell];
            const std::uint32_t slot = known != kNone ? known : add_cell(s, p, at.cell);
            p.cells[slot].reach |= std::uint64_t{1} << at.place;
            p.weights(slot)[at.place] = weight;
        };
        if (id == kNone)
            put(first);
        else
            for (const std::uint32_t copy : s.members(id)) put(copy);
    }
    for (std::uint32_t k = 0; k < p.count; ++k)
        if (p.cells[k].cell >= s.patch_scratch.grid_cells()) p.cells[k].touched |= p.cells[k].reach;
}

}  // namespace dgm::detail
