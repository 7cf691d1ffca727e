// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/lattice_strip.cpp
// Grid coordinates throughout: x = u (m-1), y = v (n-1), cell (i, j) between samples (i, j) and (i+1, j+1).
#include "geometry/chart/lattice_strip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "model/codes.h"

namespace dgm::bake {
namespace {

constexpr double kClearance = 0.15;  // cells between border and lattice: thinner strips would be slivers

double distance_to_segment(Vec2d p, Vec2d a, Vec2d b) {
    const Vec2d d = b - a;
    const double l = dot(d, d), t = l > 0 ? std::clamp(dot(p - a, d) / l, 0.0, 1.0) : 0.0;
    return length(p - (a + d * t));
}

class Joiner {
 public:
    explicit Joiner(SampledChart& chart) : chart_(chart), m_(chart.m), n_(chart.n) {
        for (const Vec2d& p : chart.border_uv) border_.push_back({p.x * (m_ - 1), p.y * (n_ - 1)});
    }

    [[nodiscard]] std::vector<std::uint32_t> run(const Triangulate& triangulate) {
        const std::size_t count = border_.size();
        for (std::size_t k = 0; k < count; ++k) clear_near(border_[k], border_[(k + 1) % count]);
        for (std::size_t k = 0; k < count; ++k) open_crossed_cells(border_[k], border_[(k + 1) % count]);
        collect();
        for (const Face& f : triangulate(points_, constraints_))
            chart_.strip.push_back({sample_[f[0]], sample_[f[1]], sample_[f[2]]});
        if (chart_.strip.empty())
            throw model::Error(model::codes::kMapInvalid, chart_.method + ": the chart has no strip");
        return crowded(flip_repeated_edges());
    }

 private:
    using Edge = std::pair<std::uint32_t, std::uint32_t>;
    [[nodiscard]] std::size_t at(std::uint32_t i, std::uint32_t j) const { return std::size_t{i} * n_ + j; }

    struct Range {
        std::uint32_t i0, i1, j0, j1;  // inclusive; empty if i0 > i1 or j0 > j1
    };
    /// Whole numbers within `margin` of the segment's box, clamped to [0, m-last] x [0, n-last].
    [[nodiscard]] Range range(Vec2d a, Vec2d b, double lower, double upper, std::uint32_t last) const {
        const auto clamp = [](double x, double hi) { return static_cast<std::uint32_t>(std::clamp(x, 0.0, hi)); };
        const double hi_i = m_ - last, hi_j = n_ - last;
        return {clamp(std::floor(std::min(a.x, b.x) - lower), hi_i), clamp(std::ceil(std::max(a.x, b.x) + upper), hi_i),
                clamp(std::floor(std::min(a.y, b.y) - lower), hi_j),
                clamp(std::ceil(std::max(a.y, b.y) + upper), hi_j)};
    }

    void clear_near(Vec2d a, Vec2d b) {
        const Range r = range(a, b, kClearance, kClearance, 1);
        for (std::uint32_t i = r.i0; i <= r.i1; ++i)
            for (std::uint32_t j = r.j0; j <= r.j1; ++j)
                if (distance_to_segment({double(i), double(j)}, a, b) < kClearance) chart_.mask[at(i, j)] = 0;
    }

    /// True if the segment meets the closed unit cell at (i, j), grown by a rounding margin: separating axes.
    [[nodiscard]] static bool meets_cell(Vec2d a, Vec2d b, double i, double j) {
        constexpr double kMargin = 1e-9;
        const Vec2d centre{i + 0.5, j + 0.5}, p = a - centre, q = b - centre, d = b - a;
        const double half = 0.5 + kMargin;
        if (std::min(p.x, q.x) > half || std::max(p.x, q.x) < -half || std::min(p.y, q.y) > half ||
            std::max(p.y, q.y) < -half)
            return false;
        return std::abs(cross(d, p)) <= half * (std::abs(d.x) + std::abs(d.y)) + kMargin * length(d);
    }

    /// A cell that the border enters is no quad: if all four corners still stand, the one nearest the border goes.
    void open_crossed_cells(Vec2d a, Vec2d b) {
        const Range r = range(a, b, 1, 0, 2);
        for (std::uint32_t i = r.i0; i <= r.i1; ++i)
            for (std::uint32_t j = r.j0; j <= r.j1; ++j) {
                if (!meets_cell(a, b, i, j)) continue;
                const std::array<std::array<std::uint32_t, 2>, 4> corners{
                    {{i, j}, {i + 1, j}, {i, j + 1}, {i + 1, j + 1}}};
                const auto masked = [&](const auto& c) { return chart_.mask[at(c[0], c[1])] != 0; };
                if (!std::all_of(corners.begin(), corners.end(), masked)) continue;
                const auto nearest =
                    std::min_element(corners.begin(), corners.end(), [&](const auto& x, const auto& y) {
                        return distance_to_segment({double(x[0]), double(x[1])}, a, b) <
                               distance_to_segment({double(y[0]), double(y[1])}, a, b);
                    });
                chart_.mask[at((*nearest)[0], (*nearest)[1])] = 0;
            }
    }

    /// Points of the triangulation: all border samples, and the lattice samples not surrounded by quads. Constraints:
    /// the border, and the lattice edges between a quad and no quad.
    void collect() {
        const auto count = static_cast<std::uint32_t>(border_.size());
        for (std::uint32_t b = 0; b < count; ++b) {
            points_.push_back(border_[b]);
            sample_.push_back(static_cast<std::uint32_t>(chart_.grid_count()) + b);
            constraints_.emplace_back(b, (b + 1) % count);
        }
        const auto quad = [&](std::int64_t i, std::int64_t j) {
            return i >= 0 && j >= 0 && i + 1 < m_ && j + 1 < n_ &&
                   chart_.has_quad(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
        };
        std::vector<std::uint32_t> point_of(chart_.grid_count(), kNone);
        for (std::int64_t i = 0; i < m_; ++i)
            for (std::int64_t j = 0; j < n_; ++j) {
                const auto s = static_cast<std::size_t>(i * n_ + j);
                if (!chart_.mask[s] || (quad(i, j) && quad(i - 1, j) && quad(i, j - 1) && quad(i - 1, j - 1))) continue;
                point_of[s] = static_cast<std::uint32_t>(points_.size());
                points_.push_back({static_cast<double>(i), static_cast<double>(j)});
                sample_.push_back(static_cast<std::uint32_t>(s));
            }
        for (std::int64_t i = 0; i < m_; ++i)
            for (std::int64_t j = 0; j < n_; ++j) {
                const auto s = static_cast<std::size_t>(i * n_ + j);
                if (i + 1 < m_ && quad(i, j) != quad(i, j - 1))
                    constraints_.emplace_back(point_of[s], point_of[s + n_]);
                if (j + 1 < n_ && quad(i, j) != quad(i - 1, j)) constraints_.emplace_back(point_of[s], point_of[s + 1]);
            }
    }

    /// Once the seam is welded, a chord of the strip may have become an edge that stands elsewhere already (its mate
    /// side has the same chord), or a triangle may name one surface point twice (at the end of a cut). Such a chord is
    /// flipped within the strip: where its two triangles make a convex quad as long as there are such chords, since the
    /// others turn over in (u, v). A limb too thin for samples of the lattice is a tube of border samples alone: there
    /// one flip calls for the next, along the limb, so the passes go on while fewer and fewer such chords are left.
    /// @return  how often each edge of the welded surface is that of a face then
    [[nodiscard]] std::map<Edge, int> flip_repeated_edges() {
        constexpr int kIdlePasses = 12;
        std::size_t fewest = std::numeric_limits<std::size_t>::max();
        bool convex = true;
        for (int idle = 0; idle < kIdlePasses; ++idle) {
            Flipped pass = flip_pass(convex);
            if (pass.repeated == 0 || (pass.flipped == 0 && !convex)) return std::move(pass.uses);
            if (pass.repeated < fewest) {
                fewest = pass.repeated;
                idle = 0;
            }
            convex = pass.flipped > 0;
        }
        return count_uses();
    }

    struct Flipped {
        std::size_t repeated = 0, flipped = 0;  // chords that should be flipped, and those that were
        std::map<Edge, int> uses = {};          // those of the welded surface, if none was
    };

    /// Flips each chord at most once, and none beside another.
    Flipped flip_pass(bool convex) {
        Flipped out;
        std::map<Edge, int>& uses = out.uses = count_uses();
        std::map<Edge, std::array<std::uint32_t, 2>> sides;  // unwelded chord -> its two strip faces
        for (std::uint32_t f = 0; f < chart_.strip.size(); ++f)
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t a = chart_.strip[f][k], b = chart_.strip[f][(k + 1) % 3];
                auto [it, fresh] = sides.try_emplace({std::min(a, b), std::max(a, b)}, std::array{f, kNone});
                if (!fresh) it->second[1] = f;
            }
        std::set<std::uint32_t> touched;
        for (const auto& [edge, faces] : sides) {
            const Edge w = welded(edge.first, edge.second);
            if (faces[1] == kNone || (uses[w] <= 2 && w.first != w.second)) continue;
            ++out.repeated;
            if (touched.count(faces[0]) || touched.count(faces[1])) continue;
            if (!flip(faces[0], faces[1], edge.first, edge.second, uses, convex)) continue;
            ++out.flipped;
            touched.insert(faces[0]);
            touched.insert(faces[1]);
            uses[w] -= 2;
        }
        return out;
    }

    /// How often each edge of the welded surface is that of a face.
    [[nodiscard]] std::map<Edge, int> count_uses() const {
        std::map<Edge, int> uses;
        for (const Face& f : chart_.faces())
            for (int k = 0; k < 3; ++k) ++uses[welded(f[k], f[(k + 1) % 3])];
        return uses;
    }

    [[nodiscard]] std::vector<std::uint32_t> crowded(const std::map<Edge, int>& uses) const {
        std::set<std::uint32_t> out;
        for (const Face& f : chart_.strip)
            for (int k = 0; k < 3; ++k) {
                const Edge w = welded(f[k], f[(k + 1) % 3]);
                if (uses.at(w) <= 2 && w.first != w.second) continue;
                for (const std::uint32_t s : {f[k], f[(k + 1) % 3]})
                    if (s >= chart_.grid_count()) out.insert(s - static_cast<std::uint32_t>(chart_.grid_count()));
            }
        return {out.begin(), out.end()};
    }

    [[nodiscard]] Edge welded(std::uint32_t a, std::uint32_t b) const {
        a = chart_.representative[a];
        b = chart_.representative[b];
        return {std::min(a, b), std::max(a, b)};
    }

    /// Twice the signed area in grid coordinates.
    [[nodiscard]] double doubled_area(const Face& f) const {
        const auto place = [&](std::uint32_t s) {
            if (s >= chart_.grid_count()) return border_[s - chart_.grid_count()];
            return Vec2d{static_cast<double>(s / n_), static_cast<double>(s % n_)};
        };
        return cross(place(f[1]) - place(f[0]), place(f[2]) - place(f[0]));
    }

    bool flip(std::uint32_t f, std::uint32_t g, std::uint32_t a, std::uint32_t b, const std::map<Edge, int>& uses,
              bool convex) {
        Face &first = chart_.strip[f], &second = chart_.strip[g];
        const auto apex = [&](const Face& face) {
            return face[0] != a && face[0] != b ? 0 : face[1] != a && face[1] != b ? 1 : 2;
        };
        const int p = apex(first), q = apex(second);
        const std::uint32_t c = first[p], d = second[q], from = first[(p + 1) % 3], to = first[(p + 2) % 3];
        const auto w = welded(c, d);
        if (w.first == w.second || uses.count(w) != 0) return false;
        const Face one{c, from, d}, other{d, to, c};
        if (convex && !(doubled_area(one) > 0 && doubled_area(other) > 0)) return false;
        first = one;
        second = other;
        return true;
    }

    SampledChart& chart_;
    const std::uint32_t m_, n_;
    std::vector<Vec2d> border_;
    std::vector<Vec2d> points_;
    std::vector<std::uint32_t> sample_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> constraints_;
};

}  // namespace

std::vector<std::uint32_t> join_lattice_to_border(SampledChart& chart, const Triangulate& triangulate) {
    return Joiner(chart).run(triangulate);
}

}  // namespace dgm::bake
