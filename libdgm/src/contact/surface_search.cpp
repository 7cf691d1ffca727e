// SPDX-License-Identifier: MIT
// libdgm/src/contact/surface_search.cpp
#include "contact/surface_search.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "surface/descent.h"

namespace dgm::detail {
namespace {

/// Nearest point of a triangle (Ericson, Real-Time Collision Detection, 5.1.5). An edge without length is passed over:
/// its ends are on the other two.
Double3 nearest_on(const Double3& p, const Double3& a, const Double3& b, const Double3& c) noexcept {
    const Double3 ab = b - a, ac = c - a, ap = p - a;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return a;
    const Double3 bp = p - b;
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 - d3 > 0) return a + (d1 / (d1 - d3)) * ab;
    const Double3 cp = p - c;
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 - d6 > 0) return a + (d2 / (d2 - d6)) * ac;
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0 && (d4 - d3) + (d5 - d6) > 0)
        return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
    const double sum = va + vb + vc;
    if (!(sum > 0)) return a;  // no area: its edges have been asked
    return a + (vb / sum) * ab + (vc / sum) * ac;
}

/// Squares that differ by less than this share of them are equal: triangles that share a corner or an edge.
constexpr double kTie = 1e-10;

/// Edges whose leans differ by less than this share of the distance are one edge, or as good as one.
constexpr double kSameLean = 1e-9;

/// How far an edge of the triangle from its corner q leads towards p: cosine to p - q, times the distance. 0 where q is
/// no corner, which is most there is: nothing on the surface is nearer than q.
double lean_of(const Double3& q, const Double3& v, const Double3& a, const Double3& b, const Double3& c) noexcept {
    const Double3 corner[3] = {a, b, c};
    for (int k = 0; k < 3; ++k) {
        if (!(corner[k].x == q.x && corner[k].y == q.y && corner[k].z == q.z)) continue;
        double lean = -kInfinity;
        for (const Double3& end : {corner[(k + 1) % 3], corner[(k + 2) % 3]}) {
            const Double3 edge = end - q;
            const double square = dot(edge, edge);
            if (square > 0) lean = std::max(lean, dot(edge, v) / std::sqrt(square));
        }
        return lean;
    }
    return 0;
}

/// The nearest of the triangles that are offered, in whatever order they come: the least square is; so is the choice
/// among all triangles with that square, which are offered once more.
///
/// At an edge the triangle that faces the point most says on which side it lies. At a corner it may not: that of a
/// needle which faces most may be on the far side. There the surface is nearest, seen from the corner, along the edge
/// that leads most towards the point, so the triangles at that edge decide.
class NearestTriangle {
 public:
    NearestTriangle(const Shape& o, Double3 p) noexcept
        : p_(p), rounding_(o.rounding + 1e-6 * std::max({std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)})) {}

    [[gnu::noinline]] void offer(const Double3& pa, const Double3& pb, const Double3& pc, std::uint64_t name) noexcept {
        const Double3 n = cross(pb - pa, pc - pa);
        const double area = dot(n, n), height = dot(n, p_ - pa);
        if (height * height > (best_.square + rounding_ * rounding_) * (1 + 1e-6) * area) return;  // so far its plane
        const Double3 q = nearest_on(p_, pa, pb, pc), v = p_ - q;
        const double square = dot(v, v);
        if (square > best_.square * (1 + kTie)) return;
        const double length = std::sqrt(area), facing = length > 0 ? dot(n, v) / length : 0;
        const Hit hit{square, facing, length > 0 ? std::fabs(facing) : -1, q, name};
        if (round_ != Round::Nearest) return choose(hit, length > 0 ? lean_of(q, v, pa, pb, pc) : -kInfinity);
        if (square < best_.square) {
            if (square * (1 + kTie) < best_.square) ties_ = 0;
            found(hit);
        }
        note_tie(name);
    }
    [[nodiscard]] const Hit& best() const noexcept { return best_; }
    /// Square of how far boxes may lie.
    [[nodiscard]] double reach() const noexcept { return reach_; }
    [[nodiscard]] double rounding() const noexcept { return rounding_; }
    /// No other triangle is as near.
    [[nodiscard]] bool is_sure() const noexcept { return ties_ <= 1; }
    [[nodiscard]] bool has_all_ties() const noexcept { return ties_ <= kMostTies; }
    [[nodiscard]] std::span<const std::uint64_t> ties() const noexcept { return {tie_, ties_}; }
    /// From now on best() is final. Triangles are offered to find the edge that leads most towards the point, then to
    /// choose the first in Hit's order among those at that edge.
    void begin_choice() noexcept { round_ = Round::Lean; }
    void end_choice() noexcept { round_ = Round::Choice; }
    [[nodiscard]] bool is_choosing() const noexcept { return round_ != Round::Nearest; }
    [[nodiscard]] Hit chosen() const noexcept {
        Hit hit = chosen_;
        hit.square = best_.square;
        return hit;
    }

 private:
    static constexpr std::uint32_t kMostTies = 12;
    enum class Round : std::uint8_t { Nearest, Lean, Choice };

    void choose(const Hit& hit, double lean) noexcept {
        if (round_ == Round::Lean) {
            lean_ = std::max(lean_, lean);
            return;
        }
        const bool is_first = chosen_.triangle == kNoTriangle;
        const bool at_edge = lean >= lean_ - kSameLean * std::sqrt(best_.square);
        if (at_edge && (is_first || hit.before(chosen_))) chosen_ = hit;
    }

    void note_tie(std::uint64_t name) noexcept {
        for (std::uint32_t k = 0; k < std::min(ties_, kMostTies); ++k)
            if (tie_[k] == name) return;
        if (ties_ < kMostTies) tie_[ties_] = name;
        if (ties_ <= kMostTies) ++ties_;
    }
    void found(const Hit& hit) noexcept {
        best_ = hit;
        reach_ = best_.square * (1 + 4e-9);
    }

    const Double3 p_;
    const double rounding_;
    double reach_ = kInfinity;
    Hit best_;  ///< the nearest so far
    Round round_ = Round::Nearest;
    double lean_ = -kInfinity;  ///< the largest among those as near
    Hit chosen_;
    std::uint32_t ties_ = 0;  ///< triangles that may be as near; kMostTies + 1: not all are in tie_
    std::uint64_t tie_[kMostTies];
};

class SurfaceSearch {
 public:
    SurfaceSearch(const Shape& o, Double3 p) noexcept : s_(*o.surface), o_(o), p_(p), nearest_(o, p) {}

    Hit run(std::uint64_t hint) noexcept {
        if (hint != kNoTriangle) start_at(hint);
        search();
        if (nearest_.is_sure()) return nearest_.best();
        nearest_.begin_choice();
        offer_ties();
        nearest_.end_choice();
        offer_ties();
        return nearest_.chosen();
    }

 private:
    void offer_ties() noexcept {
        if (!nearest_.has_all_ties()) return search();  // more than were kept: all are met once more
        for (const std::uint64_t name : nearest_.ties()) triangle(corners_of(s_, name).data(), name);
    }
    [[gnu::noinline]] void search() noexcept {
        if (search_near()) return;
        descend(
            s_.now_boxes, [&](const Box& box) { return square_to(box); },
            [&](double square) { return !(square <= nearest_.reach()); },  // empty boxes are infinitely far
            [&](std::uint32_t tile) { leaf(tile); });
    }
    /// Searches follow each other over the obstacle: the tiles around one serve the next. @return false: start from the
    /// root.
    bool search_near() noexcept {
        if (o_.near == nullptr) return false;
        NearTiles& n = *o_.near;
        const double reach = std::sqrt(nearest_.reach()) * (1 + 1e-9);
        if (!(reach < 4 * double{s_.mean_step})) return false;
        const Double3 r{reach, reach, reach};
        if (!(n.listed && holds(n.low, p_ - r) && holds(p_ + r, n.high)) && !list_near(n, reach)) return false;
        BoxesNearJob job = near_job(n.frame, n.boxes, NearTiles::kMost, (n.count + 7) / 8 * 8);
        std::uint64_t tiles = s_.rows_of->boxes_near(job);
        job.stride = job.count = 64;
        for (; tiles != 0; tiles &= tiles - 1) {
            const auto e = static_cast<std::uint32_t>(__builtin_ctzll(tiles));
            job.boxes = n.quads[e];
            search_quads(n.tiles[e], s_.rows_of->boxes_near(job));
        }
        return true;
    }
    bool list_near(NearTiles& n, double reach) noexcept {
        const double step = s_.mean_step;
        n.listed = false;
        const Double3 grace{4 * step, 4 * step, 4 * step};
        if (n.wanted && holds(n.want[0] - grace, p_) && holds(p_, n.want[1] + grace)) {
            // Samples may have moved since the box was made.
            n.want[0] = least(n.want[0], p_);
            n.want[1] = greatest(n.want[1], p_);
            if (list_near(n, n.want[0], n.want[1], 1.5 * reach + step)) return true;
        }
        n.wanted = false;
        return list_near(n, p_, p_, reach + 4 * step);
    }
    bool list_near(NearTiles& n, Double3 low, Double3 high, double margin) noexcept {
        const Double3 m{margin, margin, margin};
        n.low = low - m;
        n.high = high + m;
        const Vec3 centre = narrow(0.5 * (low + high));
        n.frame.centre[0] = centre.x;
        n.frame.centre[1] = centre.y;
        n.frame.centre[2] = centre.z;
        lay_axes(n.frame.axis);
        n.count = 0;
        bool fits = true;
        each_tile(
            s_.now_boxes,
            [&](const Box& box) {
                return fits && holds(n.low, {box.high[0], box.high[1], box.high[2]}) &&
                       holds({box.low[0], box.low[1], box.low[2]}, n.high);
            },
            [&](std::uint32_t tile) {
                fits = n.count < NearTiles::kMost;
                if (fits) n.tiles[n.count++] = tile;
            });
        if (!fits) return false;
        for (std::uint32_t e = 0; e < NearTiles::kMost; ++e) n.boxes[e] = __builtin_inff();
        for (std::uint32_t e = 0; e < n.count; ++e) {
            const std::uint32_t tile = n.tiles[e];
            float whole[6];
            lay_boxes(n.frame, tile, n.quads[e], whole);
            add_faces(n.frame, tile, whole);
            for (std::size_t side = 0; side < 6; ++side) n.boxes[side * NearTiles::kMost + e] = whole[side];
        }
        n.listed = true;
        return true;
    }
    void lay_boxes(const BoxFrame& frame, std::uint32_t tile, float* boxes, float* whole) const noexcept {
        const ChartTables& t = s_.tables;
        const std::uint32_t i0 = tile / s_.tile_cols * kTileQuads, j0 = tile % s_.tile_cols * kTileQuads;
        Rect quads{i0, std::min(i0 + kTileQuads, t.rows - 1) - 1, j0, std::min(j0 + kTileQuads, t.cols - 1) - 1};
        if (t.rows < 2 || t.cols < 2) quads = {};
        s_.rows_of->quad_boxes({quads, t.cols, Surface::fixed(s_.now), frame}, boxes, whole);
    }
    /// Grows the box of a tile around the faces beside the grid that its leaf holds.
    void add_faces(const BoxFrame& f, std::uint32_t tile, float* whole) const noexcept {
        if (!s_.has_faces(tile)) return;
        for (std::uint32_t k = s_.tile_face_start[tile]; k < s_.tile_face_start[tile + 1]; ++k)
            for (std::size_t c = 0; c < 3; ++c) {
                const Vec3 p = s_.point(s_.faces[3 * std::size_t{s_.tile_faces[k]} + c]);
                const float v[3] = {p.x - f.centre[0], p.y - f.centre[1], p.z - f.centre[2]};
                for (int d = 0; d < 3; ++d) {
                    const float at = f.axis[d][0] * v[0] + f.axis[d][1] * v[1] + f.axis[d][2] * v[2];
                    whole[2 * d] = std::min(whole[2 * d], at);
                    whole[2 * d + 1] = std::max(whole[2 * d + 1], at);
                }
            }
    }
    [[nodiscard]] BoxesNearJob near_job(const BoxFrame& f, const float* boxes, std::uint32_t stride,
                                        std::uint32_t count) const noexcept {
        BoxesNearJob job{boxes, stride, count, {}, {}, 0};
        const Double3 v = p_ - Double3{f.centre[0], f.centre[1], f.centre[2]};
        for (int d = 0; d < 3; ++d) {
            job.low[d] = job.high[d] = static_cast<float>(dot(Double3{f.axis[d][0], f.axis[d][1], f.axis[d][2]}, v));
        }
        const double reach = (std::sqrt(nearest_.reach()) + nearest_.rounding()) * (1 + 1e-6);
        job.square = reach < 1e15 ? static_cast<float>(reach * reach) : 3e38f;
        return job;
    }
    [[nodiscard]] double square_to(const Box& box) const noexcept {
        const double x = std::max(std::max(box.low[0] - p_.x, p_.x - box.high[0]), 0.0);
        const double y = std::max(std::max(box.low[1] - p_.y, p_.y - box.high[1]), 0.0);
        const double z = std::max(std::max(box.low[2] - p_.z, p_.z - box.high[2]), 0.0);
        return x * x + y * y + z * z;
    }
    [[nodiscard]] Double3 at(std::uint32_t k) const noexcept { return widen(s_.point(k)); }

    void triangle(const std::uint32_t* f, std::uint64_t name) noexcept {
        nearest_.offer(at(f[0]), at(f[1]), at(f[2]), name);
    }
    /// Along the triangle that is nearest so far and one of its edges: boxes around quads beside it are flat.
    void lay_axes(float (&axis)[3][3]) const noexcept {
        Double3 e{1, 0, 0}, n{0, 0, 1};
        if (nearest_.best().triangle != kNoTriangle) {
            const auto f = corners_of(s_, nearest_.best().triangle);
            const Double3 a = at(f[0]), ab = at(f[1]) - a, area = cross(ab, at(f[2]) - a);
            const double edge = std::sqrt(dot(ab, ab)), length = std::sqrt(dot(area, area));
            if (length > 1e-3 * edge * edge && edge > 0) {
                e = (1 / edge) * ab;
                n = (1 / length) * area;
            }
        }
        const Double3 all[3] = {e, cross(n, e), n};
        for (int d = 0; d < 3; ++d) {
            axis[d][0] = static_cast<float>(all[d].x);
            axis[d][1] = static_cast<float>(all[d].y);
            axis[d][2] = static_cast<float>(all[d].z);
        }
    }
    [[gnu::noinline]] void quad(std::uint32_t i, std::uint32_t j) noexcept {
        const ChartTables& t = s_.tables;
        const std::uint32_t k = i * t.cols + j;
        const std::uint64_t name = 2 * std::uint64_t{k};
        // As quad_triangles() has them.
        const Double3 a = at(k), b = at(k + t.cols), c = at(k + t.cols + 1), d = at(k + 1);
        if (t.diagonal(i, j) == 0) {
            nearest_.offer(a, b, c, name);
            nearest_.offer(a, c, d, name + 1);
        } else {
            nearest_.offer(a, b, d, name);
            nearest_.offer(b, c, d, name + 1);
        }
    }
    /// Steps to the quad under the point as the plane of each quad met foresees it: mostly that is the quad, and little
    /// is left to search. No answer depends on it.
    void walk_from(std::uint32_t i, std::uint32_t j) noexcept {
        const ChartTables& t = s_.tables;
        for (int step = 0; step < 3; ++step) {
            const std::uint32_t k = i * t.cols + j;
            const Double3 o = at(k), a = at(k + t.cols) - o, b = at(k + 1) - o, v = p_ - o;
            const double aa = dot(a, a), ab = dot(a, b), bb = dot(b, b), av = dot(a, v), bv = dot(b, v);
            const double det = aa * bb - ab * ab;
            if (!(det > 1e-6 * aa * bb)) break;
            const auto to = [](std::uint32_t from, double steps, std::uint32_t count) {
                const double at = std::clamp(std::floor(from + steps), 0.0, count - 2.0);
                return static_cast<std::uint32_t>(at);
            };
            const std::uint32_t next_i = to(i, (av * bb - bv * ab) / det, t.rows);
            const std::uint32_t next_j = to(j, (bv * aa - av * ab) / det, t.cols);
            if ((next_i == i && next_j == j) || !t.has_quad(next_i, next_j)) break;
            i = next_i;
            j = next_j;
        }
        quad(i, j);
    }
    void start_at(std::uint64_t name) noexcept {
        const auto k = static_cast<std::uint32_t>(name / 2);
        if (k < s_.tables.grid) return walk_from(k / s_.tables.cols, k % s_.tables.cols);
        triangle(s_.faces.data() + 3 * static_cast<std::size_t>(name - 2 * std::uint64_t{s_.tables.total}), name);
    }

    void leaf(std::uint32_t tile) noexcept {
        BoxFrame frame{};
        const Vec3 p = narrow(p_);
        frame.centre[0] = p.x;
        frame.centre[1] = p.y;
        frame.centre[2] = p.z;
        lay_axes(frame.axis);
        float boxes[6 * 64], whole[6];
        lay_boxes(frame, tile, boxes, whole);
        search_quads(tile, s_.rows_of->boxes_near(near_job(frame, boxes, 64, 64)));
    }
    void search_quads(std::uint32_t tile, std::uint64_t near) noexcept {
        const ChartTables& t = s_.tables;
        const std::uint32_t i0 = tile / s_.tile_cols * kTileQuads, j0 = tile % s_.tile_cols * kTileQuads;
        for (; near != 0; near &= near - 1) {
            const auto bit = static_cast<std::uint32_t>(__builtin_ctzll(near));
            const std::uint32_t i = i0 + bit / 8, j = j0 + bit % 8;
            // Both of its triangles.
            const bool is_done =
                !nearest_.is_choosing() && nearest_.best().triangle / 2 == std::uint64_t{i} * t.cols + j;
            if (!is_done && t.has_quad(i, j)) quad(i, j);
        }
        if (!s_.has_faces(tile)) return;
        for (std::uint32_t k = s_.tile_face_start[tile]; k < s_.tile_face_start[tile + 1]; ++k) {
            const std::uint32_t face = s_.tile_faces[k];
            triangle(s_.faces.data() + 3 * std::size_t{face}, 2 * std::uint64_t{t.total} + face);
        }
    }

    const Surface& s_;
    const Shape& o_;
    const Double3 p_;
    NearestTriangle nearest_;
};
}  // namespace

std::array<std::uint32_t, 3> corners_of(const Surface& s, std::uint64_t name) noexcept {
    const std::uint32_t cols = s.tables.cols;
    if (name < 2 * std::uint64_t{s.tables.total}) {
        const auto k = static_cast<std::uint32_t>(name / 2), i = k / cols, j = k % cols;
        return quad_triangles(i, j, cols, s.tables.diagonal(i, j))[name % 2];
    }
    const std::uint32_t* f = s.faces.data() + 3 * static_cast<std::size_t>(name - 2 * std::uint64_t{s.tables.total});
    return {f[0], f[1], f[2]};
}

Hit search_surface(const Shape& o, Double3 p, std::uint64_t hint) noexcept {
    return SurfaceSearch(o, p).run(hint);
}

}  // namespace dgm::detail
