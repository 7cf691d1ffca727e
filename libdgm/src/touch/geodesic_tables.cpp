// SPDX-License-Identifier: MIT
// libdgm/src/touch/geodesic_tables.cpp
// Tables of unfolded triangles, of sides that share an edge and of corners where shortest ways bend: once for the rest
// surface.
//
// [Hastings 1955] Approximations for digital computers. Sheet 13: the arc tangent, the same bits on every machine.
#include <algorithm>
#include <cmath>

#include "base/double3.h"
#include "touch/geodesic.h"
#include "touch/state_impl.h"

namespace dgm::detail {
namespace {

/// Corners of triangles as base tail, base head, apex; and their sides, as numbers and as corners.
struct Side {
    int number, tail, head, third;
};
struct Triangle {
    int corner[3];  ///< of the quad: a, b, c, d
    Side side[3];
};
constexpr Triangle kTriangles[2][2] = {
    {{{0, 2, 1}, {{0, 0, 1, 2}, {1, 1, 2, 0}, {4, 0, 2, 1}}}, {{0, 2, 3}, {{2, 3, 2, 0}, {3, 0, 3, 2}, {5, 0, 2, 3}}}},
    {{{1, 3, 0}, {{0, 0, 1, 3}, {3, 0, 3, 1}, {4, 1, 3, 0}}}, {{1, 3, 2}, {{1, 1, 2, 3}, {2, 3, 2, 1}, {5, 1, 3, 2}}}}};
constexpr Triangle kStrip = {{0, 1, 2}, {{0, 0, 1, 2}, {1, 1, 2, 0}, {2, 2, 0, 1}}};

Double3 from_to(const StateImpl& s, std::uint32_t a, std::uint32_t b) noexcept {
    return {double{s.rest.x[b]} - s.rest.x[a], double{s.rest.y[b]} - s.rest.y[a], double{s.rest.z[b]} - s.rest.z[a]};
}
FlatTriangle flat_triangle(const StateImpl& s, std::uint32_t tail, std::uint32_t head, std::uint32_t apex) noexcept {
    const std::uint32_t a = s.representative(tail), b = s.representative(head), c = s.representative(apex);
    if (a == b || b == c || c == a) return {};
    constexpr double kThinnest = 1e-6;
    const Double3 e = from_to(s, tail, head), f = from_to(s, tail, apex);
    const Double3 n = cross(e, f);
    const double e2 = dot(e, e), f2 = dot(f, f);
    if (!(e2 > kThinnest * kThinnest * f2)) return {0, f2 > 0 ? static_cast<float>(1 / kThinnest) : 1};
    return {static_cast<float>(dot(e, f) / e2), static_cast<float>(std::sqrt(dot(n, n)) / e2)};
}

/// Angle of the direction (x, y), y >= 0, in radians, within 2e-5 [Hastings 1955].
double angle_of(double x, double y) noexcept {
    constexpr double kHalfTurn = 3.14159265358979;
    const double far = std::max(std::fabs(x), y), near = std::min(std::fabs(x), y);
    if (!(far > 0)) return 0;
    const double t = near / far, q = t * t;
    double a = t * (0.9998660 + q * (-0.3302995 + q * (0.1801410 + q * (-0.0851330 + q * 0.0208351))));
    if (y > std::fabs(x)) a = kHalfTurn / 2 - a;
    return x < 0 ? kHalfTurn - a : a;
}

/// Visits triangles with the place of their FlatTriangle, the number of side 0, and their samples.
template <class Visit>
void each_triangle(const StateImpl& s, Visit visit) noexcept {
    const ChartTables& t = s.tables;
    for (std::uint32_t i = 0; i + 1 < t.rows; ++i)
        for (std::uint32_t j = 0; j + 1 < t.cols; ++j) {
            if (!t.has_quad(i, j)) continue;
            const std::uint32_t a = i * t.cols + j, slot = a + t.cols;
            const std::uint32_t at[4] = {a, a + t.cols, a + t.cols + 1, a + 1};
            for (std::uint32_t k = 0; k < 2; ++k) visit(kTriangles[t.diagonal(i, j)][k], 2 * slot + k, 8 * slot, at);
        }
    for (std::uint32_t f = 0; f < s.faces.size() / 3; ++f)
        visit(kStrip, s.geodesic.strip / 4 + 2 * f, s.geodesic.strip + 8 * f, s.faces.data() + 3 * std::size_t{f});
}

/// From a side of a quad to the same edge in the triangle beyond.
std::int32_t beyond(int side, std::uint32_t cols) noexcept {
    const auto n = static_cast<std::int32_t>(8 * cols);
    const std::int32_t to[6] = {-8 + 2, n + 2, 8 - 2, -n - 2, 1, -1};
    return to[side];
}

/// Where corner `k` of a quad or of a strip's triangle lies: in bases along the base, and in apexes.
struct Place {
    float one, apex;
};
Place place_of(const Triangle& t, int k) noexcept {
    return k == t.corner[0] ? Place{0, 0} : k == t.corner[1] ? Place{1, 0} : Place{0, 1};
}

Steps steps_of(const Triangle& t, const Side& in, int turned) noexcept {
    const int right = turned != 0 ? in.head : in.tail, left = turned != 0 ? in.tail : in.head;
    const Place r = place_of(t, right), l = place_of(t, left), c = place_of(t, in.third);
    Steps to{};
    to.apex = in.third;
    to.end[0] = right;
    to.end[1] = left;
    to.edge[0] = l.one - r.one;
    to.edge[1] = l.apex - r.apex;
    to.third[0] = c.one - r.one;
    to.third[1] = c.apex - r.apex;
    for (const Side& out : t.side) {
        if (out.number == in.number) continue;
        const int hand = out.tail == right || out.head == right ? 0 : 1;
        to.own[hand] = 2 * (out.number - in.number) + (out.tail != (hand == 0 ? right : in.third) ? 1 : 0) - turned;
    }
    return to;
}

void make_steps(GeodesicScratch& g, std::uint32_t cols) noexcept {
    const auto n = static_cast<std::int32_t>(cols);
    const std::int32_t sample[4] = {0, n, n + 1, 1};
    for (int turned = 0; turned < 2; ++turned) {
        for (int diagonal = 0; diagonal < 2; ++diagonal)
            for (int k = 0; k < 2; ++k)
                for (const Side& in : kTriangles[diagonal][k].side) {
                    Steps to = steps_of(kTriangles[diagonal][k], in, turned);
                    for (std::int32_t* v : {&to.apex, &to.end[0], &to.end[1]}) *v = sample[*v];
                    for (int hand = 0; hand < 2; ++hand)
                        to.out[hand] = to.own[hand] + 2 * beyond(in.number + ((to.own[hand] + turned) >> 1), cols);
                    to.half = k;
                    g.steps[diagonal][in.number][turned] = to;
                }
        for (const Side& in : kStrip.side) g.strip_steps[in.number][turned] = steps_of(kStrip, in, turned);
    }
}

/// A side without a triangle beyond it on the grid.
struct LooseSide {
    std::uint32_t low, high;  ///< representatives of its ends
    std::uint32_t side;
    bool turned;
};

/// Visits loose sides.
template <class Visit>
void each_loose(const StateImpl& s, Visit visit) noexcept {
    const GeodesicScratch& g = s.geodesic;
    each_triangle(s, [&](const Triangle& t, std::uint32_t flat, std::uint32_t side0, const std::uint32_t* at) {
        if (std::isinf(g.triangles[flat].x)) return;
        for (const Side& side : t.side) {
            const std::uint32_t own = side0 + static_cast<std::uint32_t>(side.number);
            if (own < g.strip) {
                const std::uint32_t other = own + static_cast<std::uint32_t>(beyond(side.number, s.tables.cols));
                const std::uint32_t slot = other >> 3, quad = slot - s.tables.cols;
                if (slot >= s.tables.cols) {
                    const bool cut = (g.corners[quad] & kCornerDiagonal) != 0;
                    if (!std::isinf(
                            g.triangles[2 * slot + static_cast<std::uint32_t>(g.steps[cut][other & 7][0].half)].x))
                        continue;
                }
            }
            visit(own, at[side.tail], at[side.head]);
        }
    });
}

/// Joins loose sides that share an edge of the welded surface; ends of those left alone are an open border.
/// @return false if there is no memory.
bool link_sides(StateImpl& s) noexcept {
    GeodesicScratch& g = s.geodesic;
    std::uint64_t count = 0;
    each_loose(s, [&](auto, auto, auto) { ++count; });
    Array<LooseSide> loose;
    std::uint64_t places = 2;  // at most half of them taken
    for (; places < 2 * count + 1; places *= 2) --g.hash_shift;
    if (!loose.allocate(s.allocator, count) || !g.links.allocate(s.allocator, places)) return false;
    const auto put = [&](const SideLink& link) {
        std::uint32_t k = g.hash(link.from);
        while (g.links[k].from != kNone) k = (k + 1) & static_cast<std::uint32_t>(places - 1);
        g.links[k] = link;
    };
    std::size_t at = 0;
    each_loose(s, [&](std::uint32_t side, std::uint32_t tail, std::uint32_t head) {
        const std::uint32_t a = s.representative(tail), b = s.representative(head);
        loose[at++] = {std::min(a, b), std::max(a, b), side, a > b};
        if (side < g.strip) g.corners[(side >> 3) - s.tables.cols] |= kCornerLoose;
    });
    std::sort(loose.begin(), loose.end(), [](const LooseSide& a, const LooseSide& b) {
        return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.side < b.side;
    });
    for (std::size_t first = 0, end; first < at; first = end) {
        const std::uint32_t low = loose[first].low, high = loose[first].high;
        for (end = first; end < at && loose[end].low == low && loose[end].high == high; ++end) {}
        for (std::size_t k = first; k < end; ++k) {
            const LooseSide& next = loose[k + 1 < end ? k + 1 : first];
            put({loose[k].side, next.side, loose[k].turned != next.turned});
        }
        if (end - first == 2) continue;
        for (const std::uint32_t v : {low, high}) g.corners[v] |= end - first == 1 ? kCornerRim : kCornerBends;
    }
    return true;
}

/// Ends of edges so short that the error of joining windows would be a step from one to the other.
void mark_short_edges(StateImpl& s) noexcept {
    constexpr double kShort = 0.15;  // mean steps
    const double most = kShort * double{s.mean_step};
    each_triangle(s, [&](const Triangle& t, std::uint32_t, std::uint32_t, const std::uint32_t* at) {
        for (const Side& side : t.side) {
            const Double3 e = from_to(s, at[side.tail], at[side.head]);
            if (!(dot(e, e) < most * most)) continue;
            for (const int end : {side.tail, side.head}) s.geodesic.corners[s.representative(at[end])] |= kCornerShort;
        }
    });
}

/// Shortest ways pass straight through every corner but those with more than a whole turn around them, or more than
/// half a turn on an open border.
void mark_bends(StateImpl& s) noexcept {
    constexpr double kHalfTurn = 3.14159265358979, kLeast = 0.01;
    GeodesicScratch& g = s.geodesic;
    Array<float>& angle = s.footprint.key;
    std::fill(angle.begin(), angle.end(), 0.0f);
    each_triangle(s, [&](const Triangle& t, std::uint32_t flat, std::uint32_t, const std::uint32_t* at) {
        const double x = g.triangles[flat].x, y = g.triangles[flat].y;
        if (std::isinf(x)) return;
        const double angles[3] = {angle_of(x, y), angle_of(1 - x, y), angle_of(x * (x - 1) + y * y, y)};
        for (int k = 0; k < 3; ++k) angle[s.representative(at[t.corner[k]])] += static_cast<float>(angles[k]);
    });
    for (std::uint32_t v = 0; v < s.total(); ++v) {
        const double straight = ((g.corners[v] & kCornerRim) != 0 ? 1 : 2) * kHalfTurn;
        if (angle[v] > straight + kLeast) g.corners[v] |= kCornerBends;
        angle[v] = __builtin_inff();
    }
}

/// Twice as many as wait at once on the wildest of a hundred surfaces for a reach of max_reach.
std::uint64_t window_capacity(std::uint64_t max_reach) noexcept {
    return 1024 + 32 * max_reach;
}
}  // namespace

std::uint64_t geodesic_bytes(std::uint64_t rows, std::uint64_t cols, std::uint64_t face_corners,
                             std::uint64_t max_reach) noexcept {
    const std::uint64_t loose = 2 * (rows + cols) + 2 * face_corners;
    return window_capacity(max_reach) * sizeof(Window) + loose * (4 * sizeof(SideLink) + sizeof(LooseSide)) +
           2 * (cols + face_corners / 3) * sizeof(FlatTriangle);
}

bool make_geodesics(StateImpl& s) noexcept {
    GeodesicScratch& g = s.geodesic;
    const Allocator& a = s.allocator;
    const std::uint64_t slots = std::uint64_t{s.tables.grid} + s.tables.cols, faces = s.faces.size() / 3;
    if (slots + faces >= 1u << 27) return false;  // ways have 32 bits
    g.strip = static_cast<std::uint32_t>(8 * slots);
    if (!g.triangles.allocate(a, 2 * (slots + faces)) || !g.corners.allocate(a, s.total()) ||
        !g.windows.allocate(a, window_capacity(s.max_reach)))
        return false;
    make_steps(g, s.tables.cols);
    each_triangle(s, [&](const Triangle& t, std::uint32_t flat, std::uint32_t, const std::uint32_t* at) {
        g.triangles[flat] = flat_triangle(s, at[t.corner[0]], at[t.corner[1]], at[t.corner[2]]);
    });
    for (std::uint32_t i = 0; i + 1 < s.tables.rows; ++i)
        for (std::uint32_t j = 0; j + 1 < s.tables.cols; ++j)
            if (s.tables.has_quad(i, j) && s.tables.diagonal(i, j) == 1)
                g.corners[i * s.tables.cols + j] |= kCornerDiagonal;
    for (std::uint32_t v = 0; v < s.total(); ++v)
        if (s.class_id(v) != kNone) g.corners[v] |= kCornerClass;
    if (!link_sides(s)) return false;
    mark_bends(s);
    mark_short_edges(s);
    return true;
}

}  // namespace dgm::detail
