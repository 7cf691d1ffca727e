// SPDX-License-Identifier: MIT
// libdgm/src/cloth/itself.cpp
// Keeps the layers of a cloth apart.
//
// In each substep the box pyramid of the state tells which tiles are near each other, and these which samples are near
// which triangles, and which edges near each other. Tiles side by side whose normals all lie within a right angle can
// not touch, so smooth cloth costs next to nothing [Volino, Magnenat-Thalmann 1994]. At its end samples that are nearer
// than the thickness, or on the wrong side, are pushed out, and the triangle the other way, by their masses; so are
// edges.
#include <algorithm>
#include <cmath>

#include "cloth/cloth_impl.h"

namespace dgm::detail::cloth {
namespace {

double length(Double3 v) noexcept {
    return std::sqrt(dot(v, v));
}

/// Weights of the corners at the point of a triangle that is nearest to p (Ericson, Real-Time Collision Detection
/// 5.1.5).
struct Weights {
    double at[3];
};
Weights nearest(Double3 p, Double3 a, Double3 b, Double3 c) noexcept {
    const Double3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
                 d6 = dot(ac, cp);
    if (d1 <= 0 && d2 <= 0) return {{1, 0, 0}};
    if (d3 >= 0 && d4 <= d3) return {{0, 1, 0}};
    if (d6 >= 0 && d5 <= d6) return {{0, 0, 1}};
    const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 - d3 > 0) return {{1 - d1 / (d1 - d3), d1 / (d1 - d3), 0}};
    if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 - d6 > 0) return {{1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)}};
    const double e = d4 - d3, f = d5 - d6, sum = va + vb + vc;
    if (va <= 0 && e >= 0 && f >= 0 && e + f > 0) return {{0, f / (e + f), e / (e + f)}};
    if (!(sum > 0)) return {{1, 0, 0}};
    return {{va / sum, vb / sum, vc / sum}};
}

/// Where the lines of two edges are nearest, as shares of the edges; not of parallel ones.
struct Apart {
    double at[2];
    Double3 normal;  ///< of both, unit
    bool crosses = false;
};
Apart apart(Double3 a, Double3 b, Double3 c, Double3 d) noexcept {
    const Double3 u = b - a, v = d - c, n = cross(u, v), off = c - a;
    const double square = dot(n, n);
    // Below a tenth of a radian the place is vague, and samples meet triangles there.
    if (!(square > 0.01 * dot(u, u) * dot(v, v))) return {};
    return {{dot(cross(off, v), n) / square, dot(cross(off, u), n) / square}, (1 / std::sqrt(square)) * n, true};
}

Cone cone_of(const ClothImpl& c, std::uint32_t i0, std::uint32_t j0) noexcept {
    const std::uint32_t i1 = std::min(i0 + kTileQuads, c.rows - 1), j1 = std::min(j0 + kTileQuads, c.cols - 1);
    Double3 all[kTileQuads * kTileQuads], sum;
    std::uint32_t count = 0;
    for (std::uint32_t i = i0; i < i1; ++i)
        for (std::uint32_t j = j0; j < j1; ++j) {
            const Spot k = c.spot_of(i * c.cols + j);
            const auto n = static_cast<Spot>(c.fine().on.pitch);
            const Double3 v = cross(c.place(k + n + 1) - c.place(k), c.place(k + 1) - c.place(k + n));
            const double size = length(v);
            if (!(size > 0)) continue;
            all[count] = (1 / size) * v;
            sum = sum + all[count++];
        }
    Cone out;
    const double size = length(sum);
    if (!(size > 0)) return out;
    out.axis = (1 / size) * sum;
    out.cosine = 1;
    for (std::uint32_t k = 0; k < count; ++k) out.cosine = std::min(out.cosine, dot(out.axis, all[k]));
    return out;
}

/// All normals of both lie within a right angle of each other.
bool are_smooth(const Cone& a, const Cone& b) noexcept {
    // cos(x + y + z) > 0 for x + y + z < 90 degrees, of three angles below 90 each.
    if (!(a.cosine > 0.5) || !(b.cosine > 0.5)) return false;
    const double sine_a = std::sqrt(std::max(0.0, 1 - a.cosine * a.cosine));
    const double sine_b = std::sqrt(std::max(0.0, 1 - b.cosine * b.cosine));
    const double both = a.cosine * b.cosine - sine_a * sine_b;  // cosine of the sum
    const double between = dot(a.axis, b.axis);
    return both > 0 && between > 0 && between * between > 1 - both * both;
}

struct Span {
    Double3 low, high;
};
Span span_of(std::initializer_list<Double3> points) noexcept {
    Span s{*points.begin(), *points.begin()};
    for (const Double3& p : points) {
        s.low = {std::min(s.low.x, p.x), std::min(s.low.y, p.y), std::min(s.low.z, p.z)};
        s.high = {std::max(s.high.x, p.x), std::max(s.high.y, p.y), std::max(s.high.z, p.z)};
    }
    return s;
}
bool is_within(Double3 p, const Span& s, double reach) noexcept {
    return p.x > s.low.x - reach && p.y > s.low.y - reach && p.z > s.low.z - reach && p.x < s.high.x + reach &&
           p.y < s.high.y + reach && p.z < s.high.z + reach;
}
bool do_overlap(const Span& a, const Span& b, double reach) noexcept {
    return a.low.x < b.high.x + reach && a.low.y < b.high.y + reach && a.low.z < b.high.z + reach &&
           b.low.x < a.high.x + reach && b.low.y < a.high.y + reach && b.low.z < a.high.z + reach;
}
bool do_meet(const Box& a, const Box& b, float reach) noexcept {
    for (int d = 0; d < 3; ++d)
        if (!(a.low[d] <= b.high[d] + reach && b.low[d] <= a.high[d] + reach)) return false;
    return true;
}

/// A search of one tile's samples among the triangles of other tiles.
class Search {
 public:
    Search(ClothImpl& c, const StateImpl& s, double reach) noexcept : c_(c), s_(s), reach_(reach) {}

    void run() noexcept {
        const Pyramid& y = s_.now_boxes;
        const auto local = static_cast<float>(reach_ / c_.scale);
        const std::uint32_t tiles = y.rows[0] * y.cols[0];
        for (std::uint32_t a = 0; a < tiles; ++a)
            c_.cones[a] = cone_of(c_, a / y.cols[0] * kTileQuads, a % y.cols[0] * kTileQuads);
        for (std::uint32_t a = 0; a < tiles; ++a) {
            const Box& box = y.boxes[y.start[0] + a];
            each_tile(
                y, [&](const Box& b) { return do_meet(box, b, local); },
                [&](std::uint32_t b) {
                    if (are_beside(a, b) && are_smooth(c_.cones[a], c_.cones[b])) return;
                    // In cloth that is thrown into one point all are near: the list ends before the search would.
                    if (c_.meeting_count == c_.meetings.size()) return;
                    pair(a, b);
                    if (a <= b) pair_edges(a, b);
                });
        }
    }

 private:
    [[nodiscard]] bool are_beside(std::uint32_t a, std::uint32_t b) const noexcept {
        const std::uint32_t n = s_.now_boxes.cols[0];
        const auto apart = [](std::uint32_t x, std::uint32_t y) { return x > y ? x - y : y - x; };
        return apart(a / n, b / n) <= 1 && apart(a % n, b % n) <= 1;
    }
    /// A quad of a tile.
    struct Quad {
        std::uint32_t i, j;
        Spot spot;
        Span span;
    };
    /// What lies side by side in one row of a tile.
    struct Line {
        std::uint32_t first, last;
        Span span;
    };
    static constexpr std::uint32_t kMostLines = kTileQuads + 1;
    /// Of things that are listed row by row. @return their number
    template <class Row, class Box>
    static std::uint32_t lines_of(std::uint32_t count, Line* to, Row row, Box box) noexcept {
        std::uint32_t lines = 0;
        for (std::uint32_t k = 0; k < count; ++k) {
            const Span s = box(k);
            if (k == 0 || row(k) != row(k - 1)) to[lines++] = {k, k, s};
            Line& line = to[lines - 1];
            line.last = k + 1;
            line.span = span_of({line.span.low, line.span.high, s.low, s.high});
        }
        return lines;
    }
    /// Samples of tile a against quads of tile b.
    void pair(std::uint32_t a, std::uint32_t b) noexcept {
        const std::uint32_t n = s_.now_boxes.cols[0], m = s_.now_boxes.rows[0];
        // The samples of a tile; the last row and column belong to the last tiles.
        const std::uint32_t r0 = a / n * kTileQuads, s0 = a % n * kTileQuads;
        const Rect own{r0, a / n + 1 == m ? c_.rows - 1 : r0 + kTileQuads - 1, s0,
                       a % n + 1 == n ? c_.cols - 1 : s0 + kTileQuads - 1};
        const Span mine = whole(a), other = whole(b);
        Quad quads[kTileQuads * kTileQuads];
        const std::uint32_t count = quads_of(b, mine, quads);
        if (count == 0) return;
        Line lines[kMostLines];
        const std::uint32_t line_count = lines_of(
            count, lines, [&](std::uint32_t q) { return quads[q].i; }, [&](std::uint32_t q) { return quads[q].span; });
        for (std::uint32_t i = own.i0; i <= own.i1; ++i)
            for (std::uint32_t j = own.j0; j <= own.j1; ++j) {
                const Spot k = c_.spot_of(i * c_.cols + j);
                const Double3 x = c_.place(k);
                if (c_.fine().own[k] == 0 || !is_within(x, other, reach_)) continue;
                for (std::uint32_t line = 0; line < line_count; ++line) {
                    if (!is_within(x, lines[line].span, reach_)) continue;
                    for (std::uint32_t q = lines[line].first; q < lines[line].last; ++q)
                        if (is_within(x, quads[q].span, reach_)) quad(i, j, k, quads[q]);
                }
            }
    }
    /// Those of a tile that come near a box. @return their number
    std::uint32_t quads_of(std::uint32_t tile, const Span& near, Quad* to) const noexcept {
        const std::uint32_t n = s_.now_boxes.cols[0];
        const std::uint32_t i0 = tile / n * kTileQuads, j0 = tile % n * kTileQuads;
        const auto pitch = static_cast<Spot>(c_.fine().on.pitch);
        std::uint32_t count = 0;
        for (std::uint32_t i = i0; i < std::min(i0 + kTileQuads, c_.rows - 1); ++i)
            for (std::uint32_t j = j0; j < std::min(j0 + kTileQuads, c_.cols - 1); ++j) {
                const Spot q = c_.spot_of(i * c_.cols + j);
                const Span span = span_of({c_.place(q), c_.place(q + pitch), c_.place(q + 1), c_.place(q + pitch + 1)});
                if (do_overlap(span, near, reach_)) to[count++] = {i, j, q, span};
            }
        return count;
    }
    /// Of a tile, metres.
    [[nodiscard]] Span whole(std::uint32_t tile) const noexcept {
        const Box& box = s_.now_boxes.boxes[s_.now_boxes.start[0] + tile];
        return {c_.scale * Double3{box.low[0], box.low[1], box.low[2]},
                c_.scale * Double3{box.high[0], box.high[1], box.high[2]}};
    }
    /// Edges that begin in a tile and come near a box. @return their number
    std::uint32_t edges_of(std::uint32_t tile, const Span& near, Edge* to) const noexcept {
        const std::uint32_t n = s_.now_boxes.cols[0], m = s_.now_boxes.rows[0];
        const std::uint32_t i0 = tile / n * kTileQuads, j0 = tile % n * kTileQuads;
        const std::uint32_t i1 = tile / n + 1 == m ? c_.rows - 1 : i0 + kTileQuads - 1;
        const std::uint32_t j1 = tile % n + 1 == n ? c_.cols - 1 : j0 + kTileQuads - 1;
        std::uint32_t count = 0;
        for (std::uint32_t i = i0; i <= i1; ++i)
            for (std::uint32_t j = j0; j <= j1; ++j)
                for (const std::uint32_t down : {1U, 0U}) {
                    const std::uint32_t i2 = i + down, j2 = j + 1 - down;
                    if (i2 == c_.rows || j2 == c_.cols) continue;
                    const Spot k = c_.spot_of(i * c_.cols + j), k2 = c_.spot_of(i2 * c_.cols + j2);
                    const Double3 x = c_.place(k), y = c_.place(k2);
                    const Span span = span_of({x, y});
                    if (do_overlap(span, near, reach_))
                        to[count++] = {{i, i2}, {j, j2}, {k, k2}, {x, y}, span.low, span.high};
                }
        return count;
    }
    void pair_edges(std::uint32_t a, std::uint32_t b) noexcept {
        Edge *const mine = c_.edges.data(), *const others = mine + kMostEdges;
        const std::uint32_t count = edges_of(a, whole(b), mine), most = edges_of(b, whole(a), others);
        Line lines[kMostLines];
        const std::uint32_t line_count = lines_of(
            most, lines, [&](std::uint32_t m) { return others[m].i[0]; },
            [&](std::uint32_t m) {
                return Span{others[m].low, others[m].high};
            });
        for (std::uint32_t k = 0; k < count; ++k) {
            const Span span{mine[k].low, mine[k].high};
            for (std::uint32_t line = 0; line < line_count; ++line) {
                if (!do_overlap(span, lines[line].span, reach_)) continue;
                for (std::uint32_t m = std::max(lines[line].first, a == b ? k + 1 : 0); m < lines[line].last; ++m)
                    if (do_overlap(span, {others[m].low, others[m].high}, reach_)) edge_pair(mine[k], others[m]);
            }
        }
    }
    void edge_pair(const Edge& e, const Edge& f) noexcept {
        const auto steps = [](std::uint32_t x, std::uint32_t y) { return x > y ? x - y : y - x; };
        if (steps(e.i[0], f.i[0]) <= 1 && steps(e.j[0], f.j[0]) <= 1) return;
        const Double3 both = cross(e.at[1] - e.at[0], f.at[1] - f.at[0]);
        const double far = dot(both, e.at[0] - f.at[0]);
        if (!(far * far < reach_ * reach_ * dot(both, both))) return;
        constexpr double kBeyond = 0.25;  // of their length, where they may come to cross
        const Apart there = apart(e.at[0], e.at[1], f.at[0], f.at[1]);
        if (!there.crosses || c_.meeting_count == c_.meetings.size()) return;
        for (const double at : there.at)
            if (!(std::fabs(at - 0.5) < 0.5 + kBeyond)) return;
        // A quad that the other edge bounds, or the last one beside it.
        const std::uint32_t r = std::min(f.i[0], c_.rows - 2), s = std::min(f.j[0], c_.cols - 2);
        for (int k = 0; k < 2; ++k)
            if (is_neighbour(e.i[k], e.j[k], r, s, 2) &&
                (is_neighbour(e.i[k], e.j[k], r, s, 1) || is_near_at_rest(e.i[k], e.j[k], r, s)))
                return;
        const float side = far < 0 ? -1.0f : 1.0f;
        c_.meetings[c_.meeting_count++] = {{e.spot[0], e.spot[1], f.spot[0], f.spot[1]}, side, true};
    }
    void quad(std::uint32_t i, std::uint32_t j, Spot k, const Quad& of) noexcept {
        const auto n = static_cast<Spot>(c_.fine().on.pitch);
        const Spot q = of.spot;
        const Double3 x = c_.place(k);
        const Double3 at[4] = {c_.place(q), c_.place(q + n), c_.place(q + 1), c_.place(q + n + 1)};
        if (is_neighbour(i, j, of.i, of.j, 2) &&
            (is_neighbour(i, j, of.i, of.j, 1) || is_near_at_rest(i, j, of.i, of.j)))
            return;
        constexpr int kCorners[2][3] = {{0, 1, 3}, {0, 3, 2}};
        const Spot spots[4] = {q, q + n, q + 1, q + n + 1};
        for (const auto& t : kCorners) {
            const Double3 &a = at[t[0]], &b = at[t[1]], &c = at[t[2]];
            const Weights w = nearest(x, a, b, c);
            const Double3 way = x - (w.at[0] * a + w.at[1] * b + w.at[2] * c);
            if (!(dot(way, way) < reach_ * reach_) || c_.meeting_count == c_.meetings.size()) continue;
            const float side = dot(way, cross(b - a, c - a)) < 0 ? -1.0f : 1.0f;
            c_.meetings[c_.meeting_count++] = {{k, spots[t[0]], spots[t[1]], spots[t[2]]}, side, false};
        }
    }
    /// Two steps off on uneven maps.
    [[nodiscard]] bool is_near_at_rest(std::uint32_t i, std::uint32_t j, std::uint32_t r,
                                       std::uint32_t s) const noexcept {
        const std::uint32_t first = r * c_.cols + s;
        const double near = 1.5 * double{c_.options.thickness} / c_.scale;
        for (const std::uint32_t k : {first, first + 1, first + c_.cols, first + c_.cols + 1}) {
            const Double3 way = widen(StateImpl::at(s_.rest, k)) - widen(StateImpl::at(s_.rest, i * c_.cols + j));
            if (dot(way, way) < near * near) return true;
        }
        return false;
    }
    /// Within so many steps on the grid, over seams too.
    [[nodiscard]] bool is_neighbour(std::uint32_t i, std::uint32_t j, std::uint32_t r, std::uint32_t s,
                                    std::uint32_t steps) const noexcept {
        const auto near = [&](std::uint32_t a, std::uint32_t b) {
            return a + steps >= r && a <= r + steps + 1 && b + steps >= s && b <= s + steps + 1;
        };
        if (near(i, j)) return true;
        // A sample within these steps of it that has a copy may be near the quad.
        for (std::uint32_t a = i < steps ? 0 : i - steps; a <= std::min(i + steps, c_.rows - 1); ++a)
            for (std::uint32_t b = j < steps ? 0 : j - steps; b <= std::min(j + steps, c_.cols - 1); ++b) {
                const std::uint32_t first = a * c_.cols + b;
                for (std::uint32_t k = c_.next_copy[first]; k != first; k = c_.next_copy[k])
                    if (near(k / c_.cols, k % c_.cols)) return true;
            }
        return false;
    }

    ClothImpl& c_;
    const StateImpl& s_;
    double reach_;
};

void move(ClothImpl& c, Spot k, Double3 way) noexcept {
    const auto pitch = static_cast<Spot>(c.fine().on.pitch);
    each_copy(c, k / pitch * c.cols + k % pitch, [&](std::uint32_t s) {
        const Spot to = c.spot_of(s);
        c.fine().at[0][to] += way.x;
        c.fine().at[1][to] += way.y;
        c.fine().at[2][to] += way.z;
    });
}

/// Way that a sample has gone in the substep.
Double3 gone(const ClothImpl& c, Spot k) noexcept {
    return c.place(k) - Double3{c.was[0][k], c.was[1][k], c.was[2][k]};
}

/// Two things that meet: shares of the four samples in the way from the second one to the first, how far they are to
/// go, and where to.
struct Met {
    double share[4];
    double lack = 0;
    Double3 out;
};
Met sample_and_triangle(const ClothImpl& c, const Meeting& m) noexcept {
    const Double3 x = c.place(m.spot[0]), a = c.place(m.spot[1]), b = c.place(m.spot[2]), d = c.place(m.spot[3]);
    const Weights w = nearest(x, a, b, d);
    const Double3 way = x - (w.at[0] * a + w.at[1] * b + w.at[2] * d), n = cross(b - a, d - a);
    const double size = length(n), distance = length(way), thickness = double{c.options.thickness};
    if (!(size > 0)) return {};
    const double height = double{m.side} / size * dot(n, way);
    const bool inside = w.at[0] > 0 && w.at[1] > 0 && w.at[2] > 0;
    // Beside the triangle only nearness counts: which side that is, its neighbours know.
    if (inside ? !(height < thickness) : !(distance < thickness && height > 0.5 * distance)) return {};
    return {{1, -w.at[0], -w.at[1], -w.at[2]},
            thickness - (inside ? height : distance),
            inside ? (double{m.side} / size) * n : (1 / distance) * way};
}
Met two_edges(const ClothImpl& c, const Meeting& m) noexcept {
    const Double3 a = c.place(m.spot[0]), p = c.place(m.spot[2]);
    const Apart w = apart(a, c.place(m.spot[1]), p, c.place(m.spot[3]));
    if (!w.crosses || !(w.at[0] > 0 && w.at[0] < 1 && w.at[1] > 0 && w.at[1] < 1)) return {};
    const Double3 out = double{m.side} * w.normal;
    return {{1 - w.at[0], w.at[0], w.at[1] - 1, -w.at[1]}, double{c.options.thickness} - dot(out, a - p), out};
}

bool part_from(ClothImpl& c, const Meeting& m, double friction) noexcept {
    const Met met = m.edges ? two_edges(c, m) : sample_and_triangle(c, m);
    if (!(met.lack > 0)) return false;
    const auto ease = [&](int k) { return double{c.fine().free[m.spot[k]]} / double{c.weight[m.spot[k]]}; };
    double give = 0;
    Double3 slid;
    for (int k = 0; k < 4; ++k) {
        give += met.share[k] * met.share[k] * ease(k);
        slid = slid + met.share[k] * gone(c, m.spot[k]);
    }
    if (!(give > 0)) return false;
    slid = slid - dot(slid, met.out) * met.out;
    const double rubbed = length(slid), back = rubbed > 0 ? std::min(1.0, friction * met.lack / rubbed) : 0;
    const Double3 push = (1 / give) * (met.lack * met.out - back * slid);
    for (int k = 0; k < 4; ++k) move(c, m.spot[k], (met.share[k] * ease(k)) * push);
    return true;
}
}  // namespace

void find_meetings(ClothImpl& c, const StateImpl& s, double reach) noexcept {
    c.meeting_count = 0;
    Search(c, s, reach).run();
}

std::uint32_t keep_apart(ClothImpl& c, double friction) noexcept {
    std::uint32_t first = 0;
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds; ++round) {
        std::uint32_t count = 0;
        for (std::uint32_t k = 0; k < c.meeting_count; ++k)
            count += part_from(c, c.meetings[k], round == 0 ? friction : 0) ? 1 : 0;
        if (round == 0) first = count;
        if (count == 0) break;
    }
    return first;
}

}  // namespace dgm::detail::cloth
