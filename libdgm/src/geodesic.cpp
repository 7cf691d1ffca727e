// SPDX-License-Identifier: MIT
// libdgm/src/geodesic.cpp
// Distances on the rest surface around a sample, by windows that run outwards over the welded triangles.
//
// [Chen, Han 1990] Shortest paths on a polyhedron. SoCG 1990.
// [Xin, Wang 2009] Improving Chen and Han's algorithm on the discrete geodesic problem. ACM TOG 28(4).
// A window holds straight lines from one source through an edge. Crossing a triangle it measures the corner beyond and
// splits there, and corners that bend shortest ways become sources of their own [Chen, Han]. What is nearer by way of
// a corner is left out [Xin, Wang]. With windows merged (window_queue.h) weights are within 1 % of the peak.
#include <algorithm>
#include <cmath>

#include "patch.h"
#include "state_impl.h"
#include "table_impl.h"
#include "window_queue.h"

namespace dgm::detail {
namespace {

/// Corners measured by a window merged from two may be farther by twice kMerge than they are: squared.
constexpr float kBehind = 0.96f;
/// Triangles around a corner that are looked at where it bends ways.
constexpr int kMostAround = 64;

/// A triangle seen from one of its corners, in a plane with that corner at the origin: the edge by which it is entered,
/// as in Window, with the corner at its left end (hand 0: around the right of it) or right end (1).
struct Turn {
    Way way = kNone;  ///< kNone: an open border
    Vec2 a{}, e{};
    Vec2 apex{};  ///< the third corner
};

class Fan {
 public:
    Fan(StateImpl& s, float radius, float per_step) noexcept
        : s_(s),
          g_(s.geodesic),
          apex_(g_.apex.data()),
          corners_(g_.corners.data()),
          distance_(g_.distance.data()),
          cols_(s.tables.cols),
          strip_(2 * g_.strip),
          radius_(radius),
          per_step_(per_step),
          queue_(g_, radius) {}

    void run(std::uint32_t source) noexcept {
        constexpr std::uint32_t kWindows = 4096, kWindowsASample = 64;
        static_cast<void>(offer(source, 0));
        Steps room;
        each_copy(source, [&](std::uint32_t copy) {
            each_side_at(copy, [&](Way way) { start(source, across(way, room)); });
        });
        Window w;
        for (std::uint32_t count = 0; queue_.take(w); ++count) {
            if (count > kWindows + kWindowsASample * g_.touched_count) {
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

 private:
    /// Marks samples beside one without a distance that should have one: merged windows can leave gaps where the
    /// surface is a saddle. All are marked if some windows were not followed. @return whether there are any.
    [[nodiscard]] bool find_missed() noexcept {
        const std::uint32_t beside[8] = {1, cols_ + 1, cols_, cols_ - 1};
        bool any = !complete_;
        for (std::uint32_t k = 0; k < g_.touched_count; ++k) {
            const std::uint32_t v = g_.touched[k];
            bool missed = !complete_;
            if (v < s_.tables.grid && (s_.ring[v] & kRingIrregular) == 0 && distance_[v] < radius_ - 1)
                for (int d = 0; d < 4; ++d) missed = missed || is_missed(v + beside[d]) || is_missed(v - beside[d]);
            if (missed) corners_[v] |= kCornerChanged;
            any = any || missed;
        }
        return any;
    }
    [[nodiscard, gnu::always_inline]] bool is_missed(std::uint32_t sample) const noexcept {
        return distance_[sample] == __builtin_inff() && distance_[corner(sample)] == __builtin_inff();
    }
    /// Shorter ways along edges from samples that are marked, and from those these lead to.
    [[gnu::noinline]] void go_along_edges() noexcept {
        constexpr int kRounds = 64;
        bool changed = true;
        Steps room;
        for (int round = 0; changed; ++round) {
            changed = false;
            for (std::uint32_t k = 0; k < g_.touched_count; ++k) {
                const std::uint32_t from = g_.touched[k];
                if ((corners_[from] & kCornerChanged) == 0) continue;
                corners_[from] &= static_cast<std::uint8_t>(~kCornerChanged);
                if (round == kRounds) continue;
                const Vec3 at = StateImpl::at(s_.rest, from);
                each_copy(from, [&](std::uint32_t copy) {
                    each_side_at(copy, [&](Way way) {
                        const std::uint32_t v = corner(across(way, room).end(1));
                        const Vec3 e = per_step_ * (StateImpl::at(s_.rest, v) - at);
                        if (!offer(v, distance_[from] + std::sqrt(dgm::dot(e, e)))) return;
                        corners_[v] |= kCornerChanged;
                        changed = true;
                    });
                });
            }
        }
    }

    [[nodiscard, gnu::always_inline]] std::uint32_t corner(std::uint32_t sample) const noexcept {
        return (corners_[sample] & kCornerClass) == 0 ? sample : s_.representative(sample);
    }
    /// A way of length d to v. @return whether it is the shortest so far.
    [[gnu::always_inline]] bool offer(std::uint32_t v, float d) noexcept {
        if (!(d < distance_[v]) || !(d <= radius_)) return false;
        if (distance_[v] == __builtin_inff()) g_.touched[g_.touched_count++] = v;
        distance_[v] = d;
        return true;
    }

    /// The triangle that a way leads into, as steps from where it stands.
    struct Across {
        const Steps* steps;
        std::uint32_t quad;
        Way way;
        [[nodiscard, gnu::always_inline]] std::uint32_t apex() const noexcept { return from(quad, steps->apex); }
        [[nodiscard, gnu::always_inline]] std::uint32_t end(int hand) const noexcept { return from(quad, steps->end[hand]); }
        [[nodiscard, gnu::always_inline]] Way out(int hand) const noexcept { return from(way, steps->out[hand]); }
        [[nodiscard, gnu::always_inline]] Way own(int hand) const noexcept { return from(way, steps->own[hand]); }
        [[nodiscard, gnu::always_inline]] static std::uint32_t from(std::uint32_t base, std::int32_t to) noexcept {
            return base + static_cast<std::uint32_t>(to);
        }
    };
    /// `room` holds the steps of a strip's triangle.
    [[nodiscard, gnu::always_inline]] Across across(Way way, Steps& room) const noexcept {
        if (way >= strip_) [[unlikely]] {
            room = strip_steps(way);
            return {&room, 0, way};
        }
        const std::uint32_t quad = (way >> 4) - cols_;
        return {&g_.steps[corners_[quad] & kCornerDiagonal][way >> 1 & 7][way & 1], quad, way};
    }
    [[nodiscard, gnu::noinline]] Steps strip_steps(Way way) const noexcept {
        const std::uint32_t first = (way - strip_) >> 4, k = way >> 1 & 7, next = k == 2 ? 0 : k + 1, last = k == 0 ? 2 : k - 1;
        const std::uint32_t* at = s_.faces.data() + 3 * std::size_t{first};
        const auto sample = [&](std::uint32_t corner) { return static_cast<std::int32_t>(at[corner]); };
        const auto step = [&](std::uint32_t side, Way turned) {
            return static_cast<std::int32_t>(strip_ + 16 * first + 2 * side + turned - way);
        };
        const std::int32_t none = -static_cast<std::int32_t>(way);
        if ((way & 1) == 0) return {sample(last), {sample(k), sample(next)}, {none, none}, {step(last, 1), step(next, 1)}};
        return {sample(last), {sample(next), sample(k)}, {none, none}, {step(next, 0), step(last, 0)}};
    }
    [[nodiscard, gnu::always_inline]] bool is_there(Way way) const noexcept {
        return apex_[g_.place_of(way >> 1)].along < __builtin_inff();
    }
    /// Visits the ways into the triangles that are linked to the side of a way out.
    template <class Visit>
    void each_linked(Way own, Visit visit) const noexcept {
        constexpr int kMost = 8;  // triangles at one edge
        const SideLink* link = link_of(own >> 1);
        Way turned = own & 1;
        for (int k = 0; link != nullptr && link->to != own >> 1 && k < kMost; ++k) {
            turned ^= link->turned ? 1u : 0u;
            visit(2 * link->to + turned);
            link = link_of(link->to);
        }
    }
    [[nodiscard]] const SideLink* link_of(std::uint32_t side) const noexcept {
        const SideLink* found = std::lower_bound(g_.links.begin(), g_.links.end(), side,
                                                 [](const SideLink& a, std::uint32_t b) { return a.from < b; });
        return found != g_.links.end() && found->from == side ? found : nullptr;
    }
    template <class Visit>
    void each_copy(std::uint32_t v, Visit visit) const noexcept {
        if ((corners_[v] & kCornerClass) == 0) return visit(v);
        for (const std::uint32_t copy : s_.members(s_.class_id(v))) visit(copy);
    }
    /// Visits the ways across sides of triangles at a sample that have it at their right.
    template <class Visit>
    void each_side_at(std::uint32_t sample, Visit visit) const noexcept {
        const ChartTables& t = s_.tables;
        Steps room;
        const auto look = [&](std::uint32_t side) {
            if (std::isinf(apex_[g_.place_of(side)].along)) return;
            for (const Way way : {2 * side, 2 * side + 1})
                if (across(way, room).end(0) == sample) visit(way);
        };
        if (sample < t.grid) {
            const std::uint32_t i = sample / cols_, j = sample % cols_;
            for (std::uint32_t qi = i == 0 ? 0 : i - 1; qi <= i && qi + 1 < t.rows; ++qi)
                for (std::uint32_t qj = j == 0 ? 0 : j - 1; qj <= j && qj + 1 < cols_; ++qj)
                    for (std::uint32_t k = 0; k < 6; ++k) look(8 * (qi * cols_ + qj + cols_) + k);
        }
        if (s_.face_start.empty()) return;
        for (std::uint32_t k = s_.face_start[sample]; k < s_.face_start[sample + 1]; ++k)
            for (std::uint32_t side = 0; side < 3; ++side) look(strip_ / 2 + 8 * s_.face_of[k] + side);
    }

    /// A triangle at the contact, with that at the right of the way into it.
    void start(std::uint32_t source, const Across& out) noexcept {
        const std::uint32_t left = corner(out.end(1)), apex = corner(out.apex());
        const Vec3 at = StateImpl::at(s_.rest, source);
        const Vec3 e = per_step_ * (StateImpl::at(s_.rest, left) - at), f = per_step_ * (StateImpl::at(s_.rest, apex) - at);
        const float d = std::sqrt(dgm::dot(e, e)), far = std::sqrt(dgm::dot(f, f));
        const bool fresh = offer(left, d);
        if (left == source || apex == source || !(far > 0)) return;
        const float x = dgm::dot(e, f) / far;
        const Vec3 h = e - (x / far) * f;
        const Vec2 a{far, 0}, b{x, std::sqrt(dgm::dot(h, h))};
        if (fresh) bend_later(left, out.own(0) ^ 1u, a - b, -a, b, d);
        // Its other side at the contact comes here too.
        if (out.end(1) < out.apex()) return;
        push(out.out(1), out.own(1), a, b - a, 0, 1, 0);
    }

    /// Lines that cross the edge from a to a + e between right and left go on.
    [[gnu::always_inline]] void push(Way out, Way own, Vec2 a, Vec2 e, float right, float left, float offset) noexcept {
        const float room = radius_ - offset, room2 = room * room;
        const Vec2 r = a + right * e, l = a + left * e;
        if (!(left > right)) return;
        if (!(dot(r, r) < room2) && !(dot(l, l) < room2)) {
            // Both ends are out of reach: is the middle?
            const float area = cross(a, e), e2 = dot(e, e);
            if (!(dot(r, e) < 0) || !(dot(l, e) > 0) || !(area * area < room2 * e2)) return;
        }
        const Window w{a.x, a.y, e.x, e.y, right, left, offset, out, kNone};
        if (is_there(out)) [[likely]]
            complete_ &= queue_.put(w);
        else
            push_linked(w, own);
    }
    [[gnu::noinline]] void push_linked(Window w, Way own) noexcept {
        each_linked(own, [&](Way way) {
            w.way = way;
            complete_ &= queue_.put(w);
        });
    }

    /// Everything between v and `far` is nearer by way of v [Xin, Wang 2009, section 3.3].
    [[nodiscard]] static bool is_behind(float known, Vec2 v, Vec2 far, float offset) noexcept {
        return known + length(far - v) < offset + length(far);
    }
    /// From the right end of an edge to the third corner of the triangle that a way leads into.
    [[nodiscard, gnu::always_inline]] Vec2 to_third(Way way, Vec2 e) const noexcept {
        const Apex z = apex_[g_.place_of(way >> 1)];
        const float along = (way & 1) != 0 ? 1 - z.along : z.along;
        return {along * e.x + z.height * e.y, along * e.y - z.height * e.x};
    }

    void cross_triangle(const Window& w) noexcept {
        Steps place;
        const Across out = across(w.way, place);
        const Vec2 a{w.ax, w.ay}, e{w.ex, w.ey}, ac = to_third(w.way, e), c = a + ac, cb = e - ac;
        const std::uint32_t v = corner(out.apex());
        const float known = distance_[v], c2 = dot(c, c), area = cross(a, e), whole = area - cross(e, ac);
        const float at = cross(a, ac) / whole;  // the line to c crosses the edge here
        const float first = w.right, last = w.left;
        const float right = (at - first) * whole, left = (last - at) * whole;
        const float room = known - w.offset;
        if (room > 0 && room * room > c2) reach(w, v, c, right, left);
        const bool behind = !(room > 0) || room * room < kBehind * c2;
        if (right > 0) {  // lines to the right of c
            const float from = first > 0 ? first * area / (first * area + right) : 0;
            const float to = left > 0 ? 1 : last * area / (last * area - left);
            if (!behind || !is_behind(known, c, a + from * ac, w.offset))
                push(out.out(0), out.own(0), a, ac, from, to, w.offset);
        }
        if (left > 0) {
            const float from = right > 0 ? 0 : right / (right - (1 - first) * area);
            const float to = last < 1 ? left / (left + (1 - last) * area) : 1;
            if (!behind || !is_behind(known, c, c + to * cb, w.offset))
                push(out.out(1), out.own(1), c, cb, from, to, w.offset);
        }
    }

    /// The corner at c, seen straight or around the outermost line of a window.
    [[gnu::always_inline]] void reach(const Window& w, std::uint32_t v, Vec2 c, float right,
                                      float left) noexcept {
        const Vec2 a{w.ax, w.ay}, e{w.ex, w.ey};
        Vec2 from{0, 0};
        if (right < 0) from = a + w.right * e;
        if (left < 0) from = a + w.left * e;
        const float d = w.offset + length(from) + length(c - from);
        if (offer(v, d)) bend_later(v, w.way, a - c, e, c - from, d);
    }
    /// Corner v was reached along `ray`, over a triangle that was entered at the edge from a to a + e as seen from v.
    [[gnu::always_inline]] void bend_later(std::uint32_t v, Way way, Vec2 a, Vec2 e, Vec2 ray, float d) noexcept {
        if ((corners_[v] & kCornerBends) == 0) return;
        if (!queue_.put_at(d, {a.x, a.y, e.x, e.y, ray.x, ray.y, d, way | kBend, kNone})) complete_ = false;
    }

    /// The triangle beyond an edge; the corner that is turned around is at the origin.
    [[nodiscard]] Turn turn(Way out, Way own, Vec2 a, Vec2 e) const noexcept {
        Turn t;
        if (is_there(out))
            t.way = out;
        else
            each_linked(own, [&](Way way) { t.way = way; });
        if (t.way == kNone) return t;
        t.a = a;
        t.e = e;
        t.apex = a + to_third(t.way, e);
        return t;
    }
    /// The next triangle around corner v. One with two corners in v is left across the edge opposite to that by which it
    /// was entered.
    [[nodiscard]] Turn next(const Turn& t, const Across& at, std::uint32_t v, int hand) const noexcept {
        if (corner(at.apex()) == v) return turn(at.out(hand), at.own(hand), t.a, t.e);
        return hand == 0 ? turn(at.out(1), at.own(1), t.apex, -t.apex) : turn(at.out(0), at.own(0), {0, 0}, t.apex);
    }
    /// The triangle around v into which a line goes straight on along `ray`, half a turn from where it came.
    [[nodiscard]] Turn straight_on(Turn t, std::uint32_t v, Vec2 ray, int hand) const noexcept {
        Steps room;
        for (int k = 0; t.way != kNone && k < kMostAround; ++k) {
            const Across at = across(t.way, room);
            if (corner(at.apex()) != v && (hand == 0 ? cross(ray, t.apex) : cross(t.apex, ray)) > 0) return t;
            t = next(t, at, v, hand);
        }
        return {};
    }
    /// The edge opposite to the corner a turn is around, from its right end.
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

    /// A corner becomes a source for what lies between the ways straight on around its right and around its left.
    [[gnu::noinline]] void bend(const Window& w) noexcept {
        Steps room;
        const Across in = across(w.way & ~kBend, room);
        const std::uint32_t v = corner(in.apex());
        const float d = w.offset;
        if (distance_[v] != d) return;  // there was a shorter way
        const Vec2 a{w.ax, w.ay}, b = a + Vec2{w.ex, w.ey}, ray{w.right, w.left};
        const Turn on[2] = {straight_on(turn(in.out(0), in.own(0), a, -a), v, ray, 0),
                            straight_on(turn(in.out(1), in.own(1), {0, 0}, b), v, ray, 1)};
        if (on[0].way == kNone && on[1].way == kNone) return;
        const int hand = on[0].way == kNone ? 1 : 0;
        const bool closed = on[1 - hand].way != kNone;
        const std::uint32_t end = closed ? across(on[1].way, room).own(1) >> 1 : kNone;
        Turn t = on[hand];
        float begin = meet(ray, facing(t, hand));
        for (int k = 0; t.way != kNone && k < kMostAround; ++k) {
            const Across at = across(t.way, room);
            const std::uint32_t apex = corner(at.apex());
            if (apex != v) {
                const Facing f = facing(t, hand);
                const bool last = at.own(hand) >> 1 == end;
                float finish = hand == 0 ? 1 : 0;
                if (last) finish = meet(ray, facing(on[1], 1));
                push(at.out(hand), at.own(hand), f.a, f.e, hand == 0 ? begin : finish, hand == 0 ? finish : begin, d);
                if (last) return;
                begin = 1 - finish;
                const float along = length(t.apex);
                if (offer(apex, d + along)) bend_later(apex, t.way, t.a - t.apex, t.e, t.apex, d + along);
            }
            t = next(t, at, v, hand);
        }
    }
    StateImpl& s_;
    GeodesicScratch& g_;
    const Apex* const apex_;
    std::uint8_t* const corners_;
    float* const distance_;
    const std::uint32_t cols_;
    const Way strip_;
    const float radius_, per_step_;
    bool complete_ = true;
    WindowQueue queue_;
};
}  // namespace

void fill_by_front(StateImpl& s, const TableImpl& t, const Contact& c, Patch& p) noexcept {
    const float reach = static_cast<float>(t.options.reach);
    Fan fan(s, reach, 1 / c.step);
    fan.run(s.representative(c.sample));
    const Weigher weigher(s, t, c);
    GeodesicScratch& g = s.geodesic;
    for (std::uint32_t k = 0; k < g.touched_count; ++k) {
        const std::uint32_t first = g.touched[k], id = s.class_id(first);
        const float d = g.distance[first];
        g.distance[first] = __builtin_inff();
        if (!(d < reach)) continue;
        const float weight = weigher.at(first, d);
        const auto put = [&](std::uint32_t sample) {
            std::uint32_t cell, place;
            if (sample < s.tables.grid) {  // cell_of() and place_in_cell() with one division
                const std::uint32_t i = sample / s.tables.cols, j = sample - i * s.tables.cols;
                cell = (i >> 3) * s.patch_scratch.cols + (j >> 3);
                place = (i & 7) * 8 + (j & 7);
            } else {
                cell = cell_of(s, sample);
                place = place_in_cell(s, sample);
            }
            const std::uint32_t known = s.patch_scratch.slot_of[cell], slot = known != kNone ? known : add_cell(s, p, cell);
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
