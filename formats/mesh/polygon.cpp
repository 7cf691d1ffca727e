// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/polygon.cpp
// [Meisters 1975] Meisters. Polygons have ears. American Mathematical Monthly 82, 1975.
#include "mesh/polygon.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <utility>

namespace dgm::formats {
namespace {

using model::Vec2d;
using model::Vec3d;

double turn(Vec2d a, Vec2d b, Vec2d c) {
    return cross(b - a, c - a);
}

/// The polygon seen along its Newell normal, counter-clockwise; empty if it has no plane or is not finite. Coordinates
/// are those of the input, shifted and scaled alike, so no products over- or underflow.
std::vector<Vec2d> project(std::span<const Vec3d> corners) {
    Vec3d low = corners[0], high = corners[0];
    for (const Vec3d& p : corners) {
        if (!is_finite(p)) return {};
        for (int k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], p[k]);
            high[k] = std::max(high[k], p[k]);
        }
    }
    // Halves first: high - low may overflow.
    double extent = 0;
    for (int k = 0; k < 3; ++k) extent = std::max(extent, high[k] / 2 - low[k] / 2);
    if (!(extent > 0)) return {};
    const auto local = [&](const Vec3d& p) {
        return Vec3d{(p.x / 2 - low.x / 2) / extent, (p.y / 2 - low.y / 2) / extent, (p.z / 2 - low.z / 2) / extent};
    };
    Vec3d normal;
    Vec3d previous = local(corners.back());
    for (const Vec3d& corner : corners) {
        const Vec3d p = local(corner);
        normal += {(previous.y - p.y) * (previous.z + p.z), (previous.z - p.z) * (previous.x + p.x),
                   (previous.x - p.x) * (previous.y + p.y)};
        previous = p;
    }
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
    if (!(std::abs(normal[axis]) > 0)) return {};
    const int first = normal[axis] > 0 ? (axis + 1) % 3 : (axis + 2) % 3;
    const int second = normal[axis] > 0 ? (axis + 2) % 3 : (axis + 1) % 3;
    std::vector<Vec2d> out;
    out.reserve(corners.size());
    for (const Vec3d& corner : corners) {
        const Vec3d p = local(corner);
        out.push_back({p[first], p[second]});
    }
    return out;
}

void append_fan(std::span<const std::uint32_t> loop, std::vector<CornerTriple>& out) {
    for (std::size_t k = 1; k + 1 < loop.size(); ++k) out.push_back({loop[0], loop[k], loop[k + 1]});
}

/// The corners that may spoil an ear, by place: a grid over the polygon, with about one of them a cell. A triangle then
/// meets few, however many there are.
class ReflexGrid {
 public:
    ReflexGrid(std::span<const Vec2d> points, std::span<const std::uint32_t> reflex)
        : points_(points), low_(points[0]), high_(points[0]) {
        for (const Vec2d& p : points) {
            low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
            high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y)};
        }
        side_ = static_cast<int>(std::clamp(std::sqrt(static_cast<double>(reflex.size())), 1.0, kMaxSide));
        cells_.resize(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
        for (const std::uint32_t k : reflex) cell_of(points[k]).push_back(k);
    }

    void remove(std::uint32_t k, std::uint64_t& work) {
        auto& cell = cell_of(points_[k]);
        work += cell.size();
        std::erase(cell, k);
    }

    /// Calls `test` with those in the cells that the triangle meets, until it returns true. Adds to `work` what was
    /// looked at. @return whether it did
    template <class Test>
    bool any_near(const std::array<Vec2d, 3>& triangle, std::uint64_t& work, const Test& test) const {
        const auto [bottom, top] = std::minmax({triangle[0].y, triangle[1].y, triangle[2].y});
        for (int row = row_of(bottom), last = row_of(top); row <= last; ++row) {
            const double step = (high_.y - low_.y) / side_, y = low_.y + row * step;
            const auto [left, right] = span_of(triangle, y - kSlack, y + step + kSlack);
            for (int column = column_of(left - kSlack), end = column_of(right + kSlack); column <= end; ++column) {
                const auto& cell = cells_[index(row, column)];
                work += 1 + cell.size();
                for (const std::uint32_t k : cell)
                    if (test(k)) return true;
            }
        }
        return false;
    }

 private:
    static constexpr double kMaxSide = 2048;
    static constexpr double kSlack = 1e-9;  ///< the polygon's longer side is 1: beyond all rounding

    [[nodiscard]] std::size_t index(int row, int column) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(column);
    }
    [[nodiscard]] int place(double x, double low, double high) const {
        return high > low ? static_cast<int>(std::clamp((x - low) / (high - low) * side_, 0.0, side_ - 1.0)) : 0;
    }
    [[nodiscard]] int row_of(double y) const { return place(y, low_.y, high_.y); }
    [[nodiscard]] int column_of(double x) const { return place(x, low_.x, high_.x); }
    std::vector<std::uint32_t>& cell_of(Vec2d p) { return cells_[index(row_of(p.y), column_of(p.x))]; }

    /// The least and largest x of the triangle between two heights.
    static std::pair<double, double> span_of(const std::array<Vec2d, 3>& triangle, double low, double high) {
        double left = std::numeric_limits<double>::infinity(), right = -left;
        const auto add = [&](double x) { left = std::min(left, x), right = std::max(right, x); };
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec2d a = triangle[k], b = triangle[(k + 1) % 3];
            if (a.y >= low && a.y <= high) add(a.x);
            for (const double y : {low, high})
                if ((a.y < y) != (b.y < y)) add(a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)));
        }
        return {left, right};
    }

    std::span<const Vec2d> points_;
    Vec2d low_, high_;
    int side_ = 1;
    std::vector<std::vector<std::uint32_t>> cells_;
};

class EarClipper {
 public:
    /// @param most  point tests that it may take
    EarClipper(std::vector<Vec2d> points, std::uint64_t most)
        : points_(std::move(points)), size_(points_.size()), most_(most) {
        next_.resize(size_);
        previous_.resize(size_);
        ear_length_.resize(size_);
        for (std::size_t k = 0; k < size_; ++k) {
            next_[k] = static_cast<std::uint32_t>((k + 1) % size_);
            previous_[k] = static_cast<std::uint32_t>((k + size_ - 1) % size_);
        }
        for (std::uint32_t k = 0; k < size_; ++k)
            if (!is_convex_corner(k)) reflex_.push_back(k);
        if (reflex_.size() <= kFewReflex) return;
        grid_.emplace(points_, reflex_);
        is_reflex_.resize(size_);
        for (const std::uint32_t k : reflex_) is_reflex_[k] = true;
    }

    [[nodiscard]] std::uint64_t work() const { return tests_; }

    bool run(std::vector<CornerTriple>& out) {
        std::size_t left = size_;
        std::uint32_t start = 0;
        measure_all(start, left);
        while (left > 3) {
            std::optional<std::uint32_t> best = best_ear();
            if (!best) {
                // Clipping a far ear can free another one, so look again before giving up.
                measure_all(start, left);
                best = best_ear();
            }
            if (!best || tests_ > most_) {
                std::vector<std::uint32_t> loop;
                for (std::uint32_t k = start, seen = 0; seen < left; k = next_[k], ++seen) loop.push_back(k);
                append_fan(loop, out);
                return false;
            }
            const std::uint32_t before = previous_[*best], after = next_[*best];
            out.push_back({before, *best, after});
            next_[before] = after;
            previous_[after] = before;
            ear_length_[*best] = kNoEar;
            if (start == *best) start = after;
            --left;
            forget(*best, before, after);
            measure_ear(before);
            measure_ear(after);
        }
        out.push_back({previous_[start], start, next_[start]});
        return true;
    }

 private:
    /// Up to so many, going through all of them takes less time than a grid.
    static constexpr std::size_t kFewReflex = 64;
    static constexpr double kNoEar = std::numeric_limits<double>::infinity();
    struct Ear {
        double length;
        std::uint32_t corner;
        friend bool operator>(const Ear& a, const Ear& b) {
            return a.length != b.length ? a.length > b.length : a.corner > b.corner;
        }
    };

    [[nodiscard]] bool is_convex_corner(std::uint32_t k) const {
        return turn(points_[previous_[k]], points_[k], points_[next_[k]]) > 0;
    }

    void measure_all(std::uint32_t start, std::size_t left) {
        for (std::uint32_t k = start, seen = 0; seen < left; k = next_[k], ++seen) measure_ear(k);
    }

    /// The corner that the shortest diagonal cuts off, the first of several.
    std::optional<std::uint32_t> best_ear() {
        while (!ears_.empty()) {
            const Ear ear = ears_.top();
            if (ear_length_[ear.corner] == ear.length) return ear.corner;
            ears_.pop();  // measured again since, or gone
            ++tests_;
        }
        return std::nullopt;
    }

    /// Corners only turn convex by clipping, and a clipped one is no obstacle.
    void forget(std::uint32_t clipped, std::uint32_t before, std::uint32_t after) {
        const auto is_done = [&](std::uint32_t k) {
            return k == clipped || ((k == before || k == after) && is_convex_corner(k));
        };
        if (!grid_) {
            std::erase_if(reflex_, is_done);
            return;
        }
        for (const std::uint32_t k : {before, after})  // the clipped one is convex
            if (is_reflex_[k] && is_done(k)) {
                grid_->remove(k, tests_);
                is_reflex_[k] = false;
            }
    }

    /// Squared length of the diagonal that cuts off corner k; kNoEar if k is no ear.
    void measure_ear(std::uint32_t k) {
        ear_length_[k] = kNoEar;
        ++tests_;
        if (tests_ > most_ || !is_convex_corner(k)) return;
        const std::uint32_t ia = previous_[k], ic = next_[k];
        const Vec2d a = points_[ia], b = points_[k], c = points_[ic];
        // If any corner lies inside, a reflex one does.
        const auto lies_inside = [&](std::uint32_t q) {
            if (q == ia || q == ic) return false;
            const Vec2d p = points_[q];
            // A corner that lies on one of a, b, c (a slit or bridge) does not spoil the ear by itself.
            if (p == a || p == b || p == c) return false;
            return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
        };
        if (!grid_) {
            tests_ += reflex_.size();
            if (std::any_of(reflex_.begin(), reflex_.end(), lies_inside)) return;
        } else if (grid_->any_near({a, b, c}, tests_, lies_inside)) {
            return;
        }
        ear_length_[k] = dot(c - a, c - a);
        ears_.push({ear_length_[k], k});
    }

    std::vector<Vec2d> points_;
    std::size_t size_;
    std::uint64_t most_;
    std::vector<std::uint32_t> next_, previous_, reflex_;
    std::vector<double> ear_length_;
    std::priority_queue<Ear, std::vector<Ear>, std::greater<>> ears_;
    std::optional<ReflexGrid> grid_;  ///< for many reflex corners, instead of reflex_
    std::vector<bool> is_reflex_;     ///< those in grid_
    std::uint64_t tests_ = 0;
};

bool is_convex(std::span<const Vec2d> p) {
    for (std::size_t k = 0; k < p.size(); ++k)
        if (!(turn(p[k], p[(k + 1) % p.size()], p[(k + 2) % p.size()]) > 0)) return false;
    return true;
}

}  // namespace

bool triangulate_polygon(std::span<const Vec3d> corners, std::vector<CornerTriple>& out, PolygonBudget& budget) {
    budget.earn(corners.size());
    if (corners.size() == 3) {
        out.push_back({0, 1, 2});
        return true;
    }
    std::vector<Vec2d> flat = project(corners);
    if (flat.empty()) {
        std::vector<std::uint32_t> loop(corners.size());
        for (std::size_t k = 0; k < loop.size(); ++k) loop[k] = static_cast<std::uint32_t>(k);
        append_fan(loop, out);
        return false;
    }
    if (flat.size() == 4 && is_convex(flat)) {
        out.push_back({0, 1, 2});
        out.push_back({0, 2, 3});
        return true;
    }
    EarClipper clipper(std::move(flat), budget.left());
    const bool done = clipper.run(out);
    budget.spend(clipper.work());
    return done;
}

}  // namespace dgm::formats
