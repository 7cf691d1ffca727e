// SPDX-License-Identifier: MIT
// libdgm/src/geodesic_tables.cpp
// How triangles unfold, which sides share an edge, and where shortest ways bend: worked out once for the rest surface.
//
// [Hastings 1955] Approximations for digital computers. Sheet 13: the arc tangent, the same bits on every machine.
#include "geodesic.h"

#include <algorithm>
#include <cmath>

#include "state_impl.h"

namespace dgm::detail {
namespace {

/// Corners of a quad: a, b, c, d as in quad_triangles().
struct Triangle {
    int tail, head, apex;
};
constexpr Triangle kSides[2][6] = {{{0, 1, 2}, {1, 2, 0}, {3, 2, 0}, {0, 3, 2}, {0, 2, 1}, {0, 2, 3}},
                                   {{0, 1, 3}, {1, 2, 3}, {3, 2, 1}, {0, 3, 1}, {1, 3, 0}, {1, 3, 2}}};
/// Which of the sides belong to one triangle.
constexpr int kTriangles[2][2][3] = {{{0, 1, 4}, {2, 3, 5}}, {{0, 3, 4}, {1, 2, 5}}};

struct Vec3d {
    double x, y, z;
};
Vec3d from_to(const StateImpl& s, std::uint32_t a, std::uint32_t b) noexcept {
    return {double{s.rest.x[b]} - s.rest.x[a], double{s.rest.y[b]} - s.rest.y[a], double{s.rest.z[b]} - s.rest.z[a]};
}
double dot(const Vec3d& a, const Vec3d& b) noexcept {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
double doubled_area(const Vec3d& a, const Vec3d& b) noexcept {
    const Vec3d n{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    return std::sqrt(dot(n, n));
}

Apex apex_of(const StateImpl& s, std::uint32_t tail, std::uint32_t head, std::uint32_t apex) noexcept {
    const Vec3d e = from_to(s, tail, head), f = from_to(s, tail, apex);
    const double length2 = dot(e, e);
    const auto along = static_cast<float>(dot(e, f) / length2), height = static_cast<float>(doubled_area(e, f) / length2);
    return length2 > 0 && std::isfinite(along) && std::isfinite(height) ? Apex{along, height} : Apex{};
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

template <class Visit>
void each_side(const StateImpl& s, Visit visit) noexcept {
    const ChartTables& t = s.tables;
    for (std::uint32_t i = 0; i + 1 < t.rows; ++i)
        for (std::uint32_t j = 0; j + 1 < t.cols; ++j) {
            if (!t.has_quad(i, j)) continue;
            const std::uint32_t a = i * t.cols + j;
            const std::uint32_t at[4] = {a, a + t.cols, a + t.cols + 1, a + 1};
            for (const auto& sides : kTriangles[t.diagonal(i, j)])
                for (const int k : sides) {
                    const Triangle& side = kSides[t.diagonal(i, j)][k];
                    visit(8 * (a + t.cols) + static_cast<std::uint32_t>(k), at[side.tail], at[side.head], at[side.apex]);
                }
        }
    for (std::uint32_t f = 0; f < s.faces.size() / 3; ++f)
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t* at = s.faces.data() + 3 * std::size_t{f};
            visit(s.geodesic.strip + 8 * f + k, at[k], at[(k + 1) % 3], at[(k + 2) % 3]);
        }
}

/// From a side of a quad to the same edge in the triangle beyond.
std::int32_t beyond(std::uint32_t side, std::uint32_t cols) noexcept {
    const auto n = static_cast<std::int32_t>(8 * cols);
    const std::int32_t to[6] = {-8 + 2, n + 2, 8 - 2, -n - 2, 1, -1};
    return to[side & 7];
}

void make_steps(GeodesicScratch& g, std::uint32_t cols) noexcept {
    const auto n = static_cast<std::int32_t>(cols);
    const std::int32_t sample[4] = {0, n, n + 1, 1};
    for (int diagonal = 0; diagonal < 2; ++diagonal)
        for (const auto& sides : kTriangles[diagonal])
            for (const int in : sides)
                for (int turned = 0; turned < 2; ++turned) {
                    const Triangle& t = kSides[diagonal][in];
                    const int right = turned != 0 ? t.head : t.tail, left = turned != 0 ? t.tail : t.head;
                    Steps& to = g.steps[diagonal][in][turned];
                    to.apex = sample[t.apex];
                    to.end[0] = sample[right];
                    to.end[1] = sample[left];
                    for (const int out : sides) {
                        if (out == in) continue;
                        const Triangle& o = kSides[diagonal][out];
                        const int hand = o.tail == right || o.head == right ? 0 : 1;
                        const int turn = (o.tail != (hand == 0 ? right : t.apex) ? 1 : 0) - turned;
                        to.own[hand] = 2 * (out - in) + turn;
                        to.out[hand] = to.own[hand] + 2 * beyond(static_cast<std::uint32_t>(out), cols);
                    }
                }
}

/// A side whose triangle has no neighbour beyond it on the grid.
struct LooseSide {
    std::uint32_t low, high;  ///< representatives of its ends
    std::uint32_t side;
    bool turned;
};

/// Joins sides that share an edge after welding; ends of those left alone are an open border.
/// @return false if there is no memory.
bool link_sides(StateImpl& s) noexcept {
    GeodesicScratch& g = s.geodesic;
    const std::uint32_t n = s.tables.cols;
    const auto is_there = [&](std::uint32_t side) { return !std::isinf(g.apex[g.place_of(side)].along); };
    const auto is_loose = [&](std::uint32_t side) {
        return is_there(side) && (side >= g.strip || !is_there(side + static_cast<std::uint32_t>(beyond(side, n))));
    };
    std::uint64_t count = 0;
    each_side(s, [&](std::uint32_t side, auto, auto, auto) { count += is_loose(side) ? 1 : 0; });
    Array<LooseSide> loose;
    if (!loose.allocate(s.allocator, count) || !g.links.allocate(s.allocator, count)) return false;
    std::size_t at = 0;
    each_side(s, [&](std::uint32_t side, std::uint32_t tail, std::uint32_t head, std::uint32_t) {
        const std::uint32_t a = s.representative(tail), b = s.representative(head);
        if (is_loose(side)) loose[at++] = {std::min(a, b), std::max(a, b), side, a > b};
    });
    std::sort(loose.begin(), loose.end(), [](const LooseSide& a, const LooseSide& b) {
        return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.side < b.side;
    });
    for (std::size_t first = 0, end; first < at; first = end) {
        for (end = first; end < at && loose[end].low == loose[first].low && loose[end].high == loose[first].high; ++end) {}
        for (std::size_t k = first; k < end; ++k) {
            const LooseSide& next = loose[k + 1 < end ? k + 1 : first];
            g.links[k] = {loose[k].side, next.side, loose[k].turned != next.turned};
        }
        if (end - first == 2) continue;
        for (const std::uint32_t v : {loose[first].low, loose[first].high})
            g.corners[v] |= end - first == 1 ? kCornerRim : kCornerBends;
    }
    std::sort(g.links.begin(), g.links.end(), [](const SideLink& a, const SideLink& b) { return a.from < b.from; });
    return true;
}

/// Shortest ways pass straight through every corner but those with more than a whole turn around them, or more than
/// half a turn on an open border.
void mark_bends(StateImpl& s) noexcept {
    constexpr double kHalfTurn = 3.14159265358979, kLeast = 0.01;
    GeodesicScratch& g = s.geodesic;
    std::fill(g.distance.begin(), g.distance.end(), 0.0f);
    each_side(s, [&](std::uint32_t side, std::uint32_t, std::uint32_t, std::uint32_t apex) {
        const Apex z = g.apex[g.place_of(side)];
        if (std::isinf(z.along)) return;
        const double x = z.along, y = z.height;
        g.distance[s.representative(apex)] += static_cast<float>(angle_of(x * (x - 1) + y * y, y));
    });
    for (std::uint32_t v = 0; v < s.total(); ++v) {
        const double straight = ((g.corners[v] & kCornerRim) != 0 ? 1 : 2) * kHalfTurn;
        if (g.distance[v] > straight + kLeast) g.corners[v] |= kCornerBends;
        g.distance[v] = __builtin_inff();
    }
}

/// As many as wait at once on curved organs with a reach of max_reach, and half as many again.
std::uint64_t window_capacity(std::uint64_t max_reach) noexcept {
    return 1024 + 32 * max_reach;
}
}  // namespace

std::uint64_t geodesic_bytes(std::uint64_t rows, std::uint64_t cols, std::uint64_t face_corners,
                             std::uint64_t max_reach) noexcept {
    const std::uint64_t loose = 2 * (rows + cols) + 2 * face_corners;
    return window_capacity(max_reach) * sizeof(Window) + loose * (sizeof(SideLink) + sizeof(LooseSide)) +
           (cols + face_corners / 3) * GeodesicScratch::kSides * sizeof(Apex);
}

bool make_geodesics(StateImpl& s) noexcept {
    GeodesicScratch& g = s.geodesic;
    const Allocator& a = s.allocator;
    const std::uint64_t strip = 8 * (std::uint64_t{s.tables.grid} + s.tables.cols);
    const std::uint64_t sides = strip + 8 * (std::uint64_t{s.faces.size()} / 3);
    if (sides >= 1u << 30) return false;  // ways have two bits more
    g.strip = static_cast<std::uint32_t>(strip);
    if (!g.apex.allocate(a, sides / 8 * g.kSides) || !g.corners.allocate(a, s.total()) || !g.distance.allocate(a, s.total()) ||
        !g.touched.allocate(a, s.total()) || !g.windows.allocate(a, window_capacity(s.max_reach)))
        return false;
    make_steps(g, s.tables.cols);
    each_side(s, [&](std::uint32_t side, std::uint32_t tail, std::uint32_t head, std::uint32_t apex) {
        g.apex[g.place_of(side)] = apex_of(s, tail, head, apex);
    });
    for (std::uint32_t i = 0; i + 1 < s.tables.rows; ++i)
        for (std::uint32_t j = 0; j + 1 < s.tables.cols; ++j)
            if (s.tables.has_quad(i, j) && s.tables.diagonal(i, j) == 1) g.corners[i * s.tables.cols + j] |= kCornerDiagonal;
    for (std::uint32_t v = 0; v < s.total(); ++v)
        if (s.class_id(v) != kNone) g.corners[v] |= kCornerClass;
    if (!link_sides(s)) return false;
    mark_bends(s);
    return true;
}

}  // namespace dgm::detail
