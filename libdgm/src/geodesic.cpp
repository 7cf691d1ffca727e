// SPDX-License-Identifier: MIT
// libdgm/src/geodesic.cpp
// Exact distances on the rest surface around a sample, by windows that run outwards over the welded triangles.
//
// [Chen, Han 1990] Shortest paths on a polyhedron. SoCG 1990.
// [Xin, Wang 2009] Improving Chen and Han's algorithm on the discrete geodesic problem. ACM TOG 28(4).
#include <algorithm>
#include <cmath>

#include "patch.h"
#include "state_impl.h"
#include "table_impl.h"

namespace dgm::detail {
namespace {

/// Lines that miss a corner by this angle still measure it: the corner is where two windows meet.
constexpr float kSlack = 2e-2f;
#ifndef KM
#define KM 0.01f
#endif
#ifndef KG
#define KG 0.1f
#endif
constexpr float kMerge = KM, kGap = KG;

struct Vec2 {
    float x, y;
};
[[gnu::always_inline]] inline Vec2 operator+(Vec2 a, Vec2 b) noexcept { return {a.x + b.x, a.y + b.y}; }
[[gnu::always_inline]] inline Vec2 operator-(Vec2 a, Vec2 b) noexcept { return {a.x - b.x, a.y - b.y}; }
[[gnu::always_inline]] inline Vec2 operator*(float k, Vec2 a) noexcept { return {k * a.x, k * a.y}; }
[[gnu::always_inline]] inline float cross(Vec2 a, Vec2 b) noexcept { return a.x * b.y - a.y * b.x; }
[[gnu::always_inline]] inline float dot(Vec2 a, Vec2 b) noexcept { return a.x * b.x + a.y * b.y; }
[[gnu::always_inline]] inline float length(Vec2 a) noexcept { return std::sqrt(dot(a, a)); }

struct Exits {
    std::uint32_t apex;  ///< sample
    SideExit exit[2];
};

class Fan {
    struct Late {
        std::uint32_t to, v;
        float length, d;
        int hand;
    };
    static constexpr std::uint32_t kMostLate = 256;
    /// One triangle further around the corner that stands at the left (right = 0: at the right) end of the edge.
    struct Turn {
        std::uint32_t to;
        Vec2 a, e;  ///< edge as in Window, from the corner as origin
        bool there;
    };
    struct Beside {
        Exits out;
        Vec2 apex;
        std::uint32_t side;
    };
 public:
    Fan(StateImpl& s, float radius, float per_step) noexcept
        : s_(s), g_(s.geodesic), apex_(g_.apex.data()), distance_(g_.distance.data()), radius_(radius), per_step_(per_step),
          per_bucket_(static_cast<float>(GeodesicScratch::kBuckets - 1) / radius) {
        std::fill_n(g_.buckets, GeodesicScratch::kBuckets, kNone);
    }

    void run(std::uint32_t source) noexcept {
        reach_corner(source, 0);
        if (s_.class_id(source) == kNone)
            start(source, source);
        else
            for (const std::uint32_t copy : s_.members(s_.class_id(source))) start(source, copy);
        bend_late();
        for (; bucket_ < GeodesicScratch::kBuckets; ++bucket_)
            while (g_.buckets[bucket_] != kNone && in_budget()) {
                const std::uint32_t k = g_.buckets[bucket_];
                const Window w = g_.windows[k];
                g_.buckets[bucket_] = w.next;
                g_.windows[k].to = kNone;
                g_.windows[k].next = free_;
                free_ = k;
                propagate(w);
                bend_late();
            }
    }
    std::uint64_t count = 0, merged = 0;

 private:
    /// Crumpled surfaces could go on for ever. What is not reached by then is left out or keeps a longer way: organs take
    /// less than a tenth of it.
    [[nodiscard]] bool in_budget() noexcept { return ++work_ < 1000 * (std::uint64_t{g_.touched_count} + 100); }
    std::uint64_t work_ = 0;

    void bend_late() noexcept {
        while (late_ != 0 && in_budget()) {
            const Late at = later_[--late_];
            if (distance_[at.v] == at.d) bend_beside(at);
        }
    }
    [[nodiscard, gnu::always_inline]] std::uint32_t corner(std::uint32_t sample) const noexcept {
        return (g_.corners[sample] & kCornerClass) == 0 ? sample : s_.representative(sample);
    }
    void reach_corner(std::uint32_t v, float d) noexcept {
        if (distance_[v] == __builtin_inff()) g_.touched[g_.touched_count++] = v;
        distance_[v] = d;
    }

    /// Ways out of the triangle at a side.
    [[nodiscard, gnu::always_inline]] Exits exits(std::uint32_t to) const noexcept {
        const std::uint32_t side = to >> 1, turned = to & 1;
        if (side < g_.strip) {
            const std::uint32_t quad = (side >> 3) - s_.tables.cols;
            const SideSteps& steps = g_.steps[g_.corners[quad] & kCornerDiagonal][side & 7][turned];
            return {quad + static_cast<std::uint32_t>(steps.apex), {steps.exit[0], steps.exit[1]}};
        }
        const std::uint32_t k = side & 3, f = (side - g_.strip) >> 2;
        const std::int32_t next = (k == 2 ? 0 : static_cast<std::int32_t>(k) + 1) - static_cast<std::int32_t>(k);
        const std::int32_t last = (k == 0 ? 2 : static_cast<std::int32_t>(k) - 1) - static_cast<std::int32_t>(k);
        const std::int32_t none = -static_cast<std::int32_t>(side);
        const std::uint32_t apex = s_.faces[3 * std::size_t{f} + (k == 0 ? 2 : k - 1)];
        if (turned == 0) return {apex, {{last, none, true}, {next, none, true}}};
        return {apex, {{next, none, false}, {last, none, false}}};
    }
    /// Visits the sides that are the same edge as an exit, with `to` as in Window.
    template <class Visit>
    [[gnu::always_inline]] void beyond(std::uint32_t side, const SideExit& exit, Visit visit) const noexcept {
        const std::uint32_t other = side + static_cast<std::uint32_t>(exit.other);
        if (apex_[other].along < __builtin_inff()) [[likely]]
            return visit(2 * other + (exit.turned ? 1 : 0));
        beyond_link(side + static_cast<std::uint32_t>(exit.own), exit.turned, visit);
    }
    template <class Visit>
    [[gnu::noinline]] void beyond_link(std::uint32_t own, bool turned, Visit visit) const noexcept {
        const SideLink* link = find(own);
        if (link == nullptr) return;
        for (int k = 0; link->to != own && k < 8; ++k) {
            turned = turned != link->turned;
            visit(2 * link->to + (turned ? 1 : 0));
            link = find(link->to);
        }
    }
    [[nodiscard]] const SideLink* find(std::uint32_t side) const noexcept {
        const SideLink* found = std::lower_bound(g_.links.begin(), g_.links.end(), side,
                                                 [](const SideLink& a, std::uint32_t b) { return a.from < b; });
        return found != g_.links.end() && found->from == side ? found : nullptr;
    }

    /// Hands on the lines that cross the edge at a + right e .. a + left e.
    void push(std::uint32_t side, const SideExit& exit, Vec2 a, Vec2 e, float right, float left, float offset) noexcept {
        if (!(left > right)) return;
        const float room = radius_ - offset, room2 = room * room;
        const Vec2 r = a + right * e, l = a + left * e;
        if (!(room > 0)) return;
        if (!(dot(r, r) < room2) && !(dot(l, l) < room2)) {
            // Both ends are out of reach: is the middle?
            const float area = cross(a, e), e2 = dot(e, e);
            if (!(dot(r, e) < 0) || !(dot(l, e) > 0) || !(area * area < room2 * e2)) return;
        }
        beyond(side, exit, [&](std::uint32_t to) { queue({a.x, a.y, e.x, e.y, right, left, offset, to, kNone}); });
    }
    void queue(const Window& w) noexcept {
        std::uint32_t& recent = g_.recent[(w.to * 2654435769u) >> 22];
        if (recent < used_ && g_.windows[recent].to == w.to && merge(g_.windows[recent], w)) { ++merged; return; }
        std::uint32_t k = free_;
        if (k != kNone)
            free_ = g_.windows[k].next;
        else if (used_ < g_.windows.size())
            k = used_++;
        else
            return;
        const float d = w.offset + length({w.ax + 0.5f * w.ex, w.ay + 0.5f * w.ey});
        const std::uint32_t bucket = std::clamp(static_cast<std::uint32_t>(std::min(d * per_bucket_, 1000.0f)), bucket_, GeodesicScratch::kBuckets - 1);
        g_.windows[k] = w;
        g_.windows[k].next = g_.buckets[bucket];
        g_.buckets[bucket] = k;
        recent = k;
    }
    /// One window for two at the same edge, if their sources are nearly one as seen from there.
    [[nodiscard]] bool merge(Window& first, const Window& w) noexcept {
        if (first.offset != w.offset) return false;
        const Vec2 a1{first.ax, first.ay}, e1{first.ex, first.ey}, a2{w.ax, w.ay}, e2{w.ex, w.ey};
        const float length2 = dot(e2, e2), inverse = 1 / length2;
        // Sources seen from the edge, which is (0, 0) to (1, 0).
        const Vec2 s1{-inverse * dot(a1, e1), inverse * cross(a1, e1)}, s2{-inverse * dot(a2, e2), inverse * cross(a2, e2)};
        const Vec2 shift = s2 - s1;
        const float low = std::max(first.right, w.right), high = std::min(first.left, w.left), joint = 0.5f * (low + high);
        const float right = std::min(first.right, w.right), left = std::max(first.left, w.left), width = left - right;
        const Vec2 j1{s1.x - joint, s1.y}, j2{s2.x - joint, s2.y};
        const float d2 = dot(j1, j1), step = dot(j2, j2) - d2, gap = low - high;
        const float most = kMerge * d2;
        if (!(step * step < 4 * kMerge * kMerge * d2 * d2) || !(dot(shift, shift) * width * width < most * most) ||
            !(gap * s1.y < kGap * d2))
            return false;
        const float w1 = first.left - first.right, w2 = w.left - w.right, share = w2 / (w1 + w2);
        const Vec2 s = s1 + share * shift;
        // a = -s e, with the source at the origin.
        first = {s.y * e2.y - s.x * e2.x, -s.x * e2.y - s.y * e2.x, e2.x, e2.y, right, left, w.offset, w.to, first.next};
        return true;
    }

    void start(std::uint32_t source, std::uint32_t copy) noexcept {
        const ChartTables& t = s_.tables;
        if (copy < t.grid) {
            const std::uint32_t i = copy / t.cols, j = copy % t.cols;
            for (std::uint32_t qi = i == 0 ? 0 : i - 1; qi <= i && qi + 1 < t.rows; ++qi)
                for (std::uint32_t qj = j == 0 ? 0 : j - 1; qj <= j && qj + 1 < t.cols; ++qj) {
                    if (!t.has_quad(qi, qj)) continue;
                    const std::uint32_t q = qi * t.cols + qj;
                    for (std::uint32_t k = 0; k < 6; ++k) start_side(source, copy, 8 * (q + t.cols) + k);
                }
        }
        if (s_.face_start.empty()) return;
        for (std::uint32_t k = s_.face_start[copy]; k < s_.face_start[copy + 1]; ++k)
            for (std::uint32_t side = 0; side < 3; ++side) start_side(source, copy, g_.strip + 4 * s_.face_of[k] + side);
    }
    /// If a side is one whose right end is the source, the first window leaves by its left exit.
    void start_side(std::uint32_t source, std::uint32_t copy, std::uint32_t side) noexcept {
        for (std::uint32_t turned = 0; turned < 2; ++turned) {
            const std::uint32_t right = end_of(side, turned != 0), left = end_of(side, turned == 0);
            if (right != copy) continue;
            const Exits out = exits(2 * side + turned);
            const Vec3 at = StateImpl::at(s_.rest, source);
            const Vec3 e = StateImpl::at(s_.rest, left) - at, f = StateImpl::at(s_.rest, out.apex) - at;
            const float d = per_step_ * std::sqrt(dgm::dot(e, e));
            if (corner(left) == source || corner(out.apex) == source) {
                offer(corner(left), d);
                continue;
            }
            if (offer(corner(left), d)) bend_later(2 * side + turned, 0, corner(left), d, d);
            if (left < out.apex) continue;  // the other side at the source does it
            // The plane: the source, the apex at the right, the left end.
            const float length2 = dgm::dot(f, f), inverse = per_step_ / std::sqrt(length2), x = dgm::dot(e, f) * inverse;
            const Vec3 h = (per_step_ * e) - (x * inverse / per_step_) * f;
            const Vec2 a{per_step_ * std::sqrt(length2), 0}, b{x, std::sqrt(dgm::dot(h, h))};
            push(side, out.exit[1], a, b - a, 0, 1, 0);
        }
    }
    void bend_later(const Beside& at, int hand, float length, float d) noexcept {
        const SideExit& exit = at.out.exit[1 - hand];
        bend_later(2 * (at.side + static_cast<std::uint32_t>(exit.own)) + (exit.turned ? 0 : 1), hand, corner(at.out.apex), length, d);
    }
    void bend_later(std::uint32_t to, int hand, std::uint32_t v, float length, float d) noexcept {
        if ((g_.corners[v] & kCornerBends) != 0 && late_ < kMostLate) later_[late_++] = {to, v, length, d, hand};
    }
    /// A way along an edge to corner v.
    void bend_beside(const Late& at) noexcept {
        const Exits out = exits(at.to);
        const SideExit& exit = out.exit[at.hand];
        const std::uint32_t last = (at.to >> 1) + static_cast<std::uint32_t>(exit.own);
        const Exits back = exits(2 * last + (exit.turned ? 0 : 1));
        const Vec2 c{at.length, 0}, none{0, 0};
        if (at.hand == 0)
            bend({at.to, none - c, c, true}, cross_over(last, back.exit[1], none, none - c), at.v, c, at.d);
        else
            bend(cross_over(last, back.exit[0], none - c, c), {at.to, none, none - c, true}, at.v, c, at.d);
    }
    [[nodiscard]] std::uint32_t end_of(std::uint32_t side, bool head) const noexcept {
        if (side >= g_.strip) {
            const std::uint32_t f = (side - g_.strip) >> 2, k = side & 3;
            return s_.faces[3 * std::size_t{f} + (head ? (k == 2 ? 0 : k + 1) : k)];
        }
        const std::uint32_t quad = (side >> 3) - s_.tables.cols, n = s_.tables.cols;
        const bool cut = (g_.corners[quad] & kCornerDiagonal) != 0;
        const std::uint32_t ends[6][2] = {{0, n}, {n, n + 1}, {1, n + 1}, {0, 1}, {cut ? n : 0, cut ? 1 : n + 1}, {cut ? n : 0, cut ? 1 : n + 1}};
        return quad + ends[side & 7][head ? 1 : 0];
    }
    bool offer(std::uint32_t v, float d) noexcept {
        if (!(d < distance_[v]) || !(d <= radius_)) return false;
        reach_corner(v, d);
        return true;
    }

    /// Where the line along `ray` meets the edge.
    [[nodiscard]] static float meet(Vec2 ray, Vec2 a, Vec2 e) noexcept {
        const float k = cross(a, ray) / cross(ray, e);
        return std::min(std::max(k, 0.0f), 1.0f);
    }
    /// Every point of a window that ends at `far` is nearer by way of corner v [Xin, Wang 2009, 3.3].
    [[nodiscard]] bool is_behind(float known, Vec2 v, Vec2 far, float offset) const noexcept {
        return known + length(far - v) < offset + length(far);
    }

    void propagate(const Window w) noexcept {
        ++count;
        const std::uint32_t side = w.to >> 1;
        const Apex z = apex_[side];
        const Exits out = exits(w.to);
        const float along = (w.to & 1) != 0 ? 1 - z.along : z.along;
        const Vec2 a{w.ax, w.ay}, e{w.ex, w.ey};
        const Vec2 ac{along * e.x + z.height * e.y, along * e.y - z.height * e.x};
        const Vec2 c = a + ac, cb = e - ac;
        const std::uint32_t v = corner(out.apex);
        const float known = distance_[v], room = known - w.offset, c2 = dot(c, c);
        // The line to c crosses the edge at `at`.
        const float area = cross(a, e), whole = area + z.height * dot(e, e), at = cross(a, ac) / whole;
        const float right = (at - w.right) * whole, left = (w.left - at) * whole;
        if (right > -kSlack * c2 && left > -kSlack * c2 && !(room < 0)) {
            const float d = w.offset + std::sqrt(c2);
            if (d < known && d <= radius_) {
                reach_corner(v, d);
                if ((g_.corners[v] & kCornerBends) != 0) bend_within(w, out, c, d);
            }
        }
        const bool behind = room < 0 || room * room < c2 * 0.9999f;
        if (right > 0) {  // lines to the right of the corner
            const float from = w.right * area / (w.right * area + right);
            const float to = left > 0 ? 1 : w.left * area / (w.left * area - left);
            if (!behind || !is_behind(known, c, a + from * ac, w.offset)) push(side, out.exit[0], a, ac, from, to, w.offset);
        }
        if (left > 0) {
            const float from = right > 0 ? 0 : right / (right - (1 - w.right) * area);
            const float to = left / (left + (1 - w.left) * area);
            if (!behind || !is_behind(known, c, c + to * cb, w.offset)) push(side, out.exit[1], c, cb, from, to, w.offset);
        }
    }

    [[nodiscard]] Beside beside(const Turn& t) const noexcept {
        const Apex z = apex_[t.to >> 1];
        const float along = (t.to & 1) != 0 ? 1 - z.along : z.along;
        return {exits(t.to), t.a + Vec2{along * t.e.x + z.height * t.e.y, along * t.e.y - z.height * t.e.x}, t.to >> 1};
    }
    [[nodiscard]] Turn cross_over(std::uint32_t side, const SideExit& exit, Vec2 a, Vec2 e) const noexcept {
        Turn turn{0, a, e, false};
        beyond(side, exit, [&](std::uint32_t to) {
            turn.to = to;
            turn.there = true;
        });
        return turn;
    }
    /// From a turn over `at`, entered by exit `hand` of the triangle before. The edge opposite the corner is exit `hand`
    /// and the way on is the other.
    [[nodiscard]] Turn onwards(const Turn& t, const Beside& b, int hand) const noexcept {
        return hand == 0 ? cross_over(b.side, b.out.exit[1], b.apex, Vec2{0, 0} - b.apex)
                         : cross_over(b.side, b.out.exit[0], {0, 0}, b.apex);
        (void)t;
    }

    void bend_within(const Window& w, const Exits& out, Vec2 c, float d) noexcept {
        const Vec2 a = Vec2{w.ax, w.ay} - c, b = a + Vec2{w.ex, w.ey};
        const std::uint32_t side = w.to >> 1;
        bend(cross_over(side, out.exit[0], a, Vec2{0, 0} - a), cross_over(side, out.exit[1], {0, 0}, b), corner(out.apex), c, d);
    }

    /// Corner v at c bends ways: those of lines from v that are not straight on.
    [[gnu::noinline]] void bend(const Turn& right, const Turn& left, std::uint32_t v, Vec2 c, float d) noexcept {
        constexpr int kMost = 64;
        // hand 0: around the right, so that the corner is the left end of each edge.
        Turn exit[2];
        Beside found[2];
        bool open[2] = {true, true};
        for (int hand = 0; hand < 2; ++hand) {
            Turn t = hand == 0 ? right : left;
            int k = 0;
            for (; t.there && k < kMost; ++k) {
                const Beside at = beside(t);
                if (corner(at.out.apex) == v) {
                    t = hand == 0 ? cross_over(at.side, at.out.exit[0], t.a, t.e) : cross_over(at.side, at.out.exit[1], t.a, t.e);
                    continue;
                }
                if ((hand == 0 ? cross(c, at.apex) : cross(at.apex, c)) > 0) {
                    exit[hand] = t;
                    found[hand] = at;
                    open[hand] = false;
                    break;
                }
                t = onwards(t, at, hand);
            }
        }
        if (open[0] && open[1]) return;
        const int hand = open[0] ? 1 : 0;
        const bool limited = !open[1 - hand];
        const std::uint32_t limit = limited ? opposite(found[1 - hand], 1 - hand) : 0;
        Turn t = exit[hand];
        for (int k = 0; t.there && k < kMost; ++k) {
            const Beside at = beside(t);
            if (corner(at.out.apex) == v) {
                t = hand == 0 ? cross_over(at.side, at.out.exit[0], t.a, t.e) : cross_over(at.side, at.out.exit[1], t.a, t.e);
                continue;
            }
            const Vec2 near = hand == 0 ? t.a : t.a + t.e;
            Vec2 from = k == 0 ? c : near, to = at.apex;
            const bool last = limited && opposite(at, hand) == limit;
            const float there = length(at.apex);
            if (offer(corner(at.out.apex), d + there) && !last) bend_later(at, hand, there, d + there);
            const Vec2 pa = hand == 0 ? near : at.apex, pe = hand == 0 ? at.apex - near : near - at.apex;
            if (last) {
                // The other side's straight way on, laid into this plane by the edge both know.
                const Turn& o = exit[1 - hand];
                const Vec2 far = hand == 0 ? o.a + o.e : o.a;
                const Vec2 oe = hand == 0 ? far - found[1].apex : found[0].apex - far;
                const Vec2 turn{pe.x * oe.x + pe.y * oe.y, pe.y * oe.x - pe.x * oe.y};
                to = {c.x * turn.x - c.y * turn.y, c.x * turn.y + c.y * turn.x};
                if (!((hand == 0 ? cross(from, to) : cross(to, from)) > 0)) return;
            }
            const float begin = k == 0 ? meet(from, pa, pe) : hand == 0 ? 0 : 1, finish = last ? meet(to, pa, pe) : hand == 0 ? 1 : 0;
            push(at.side, at.out.exit[hand], pa, pe, hand == 0 ? begin : finish, hand == 0 ? finish : begin, d);
            if (last) return;
            t = onwards(t, at, hand);
        }
    }
    [[nodiscard]] static std::uint32_t opposite(const Beside& at, int hand) noexcept {
        return at.side + static_cast<std::uint32_t>(at.out.exit[hand].own);
    }

    StateImpl& s_;
    GeodesicScratch& g_;
    const Apex* const apex_;
    float* const distance_;
    const float radius_;  ///< steps
    const float per_step_;
    const float per_bucket_;
    Late later_[kMostLate];
    std::uint32_t late_ = 0;
    std::uint32_t bucket_ = 0;
    std::uint32_t free_ = kNone, used_ = 0;  ///< windows
};
}  // namespace

#ifdef GEO_COUNT
std::uint64_t geo_windows = 0, geo_samples = 0;
#endif

void fill_by_front(StateImpl& s, const TableImpl& t, const Contact& c, Patch& p) noexcept {
    const float reach = static_cast<float>(t.options.reach);
    Fan fan(s, reach, 1 / c.step);
    fan.run(s.representative(c.sample));
    const Weigher weigher(s, t, c);
    GeodesicScratch& g = s.geodesic;
#ifdef GEO_COUNT
    geo_windows += fan.count; geo_samples += g.touched_count;
#endif
    for (std::uint32_t k = 0; k < g.touched_count; ++k) {
        const std::uint32_t first = g.touched[k], id = s.class_id(first);
        const float d = g.distance[first];
        g.distance[first] = __builtin_inff();
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
