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

#include "model/codes.h"

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
    // By a power of two, which rounds nothing: corners in line stay in line.
    extent = std::ldexp(1.0, std::ilogb(extent));
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

/// No triangle of them has an area, so they leave no faces that could lie over one another.
bool in_line(std::span<const Vec3d> corners) {
    const Vec3d from = corners[0];
    const auto distance = [&](const Vec3d& p) { return dot(p - from, p - from); };
    const Vec3d to = *std::max_element(corners.begin(), corners.end(), [&](const Vec3d& p, const Vec3d& q) {
        return distance(p) < distance(q);
    }) - from;
    return std::all_of(corners.begin(), corners.end(), [&](const Vec3d& p) { return cross(p - from, to) == Vec3d{}; });
}

void append_fan(std::span<const std::uint32_t> loop, std::vector<CornerTriple>& out) {
    for (std::size_t k = 1; k + 1 < loop.size(); ++k) out.push_back({loop[0], loop[k], loop[k + 1]});
}

/// The corners that may spoil an ear, by place: a balanced tree of boxes that shrink as corners are removed. A triangle
/// meets few of them, however many corners there are and wherever they crowd.
class ReflexTree {
 public:
    ReflexTree(std::span<const Vec2d> points, std::vector<std::uint32_t> reflex)
        : points_(points), corners_(std::move(reflex)), place_of_(points.size(), kNowhere) {
        if (corners_.empty()) return;
        build(0, corners_.size());
        for (std::size_t k = 0; k < corners_.size(); ++k) place_of_[corners_[k]] = k;
    }

    [[nodiscard]] bool has(std::uint32_t corner) const { return place_of_[corner] != kNowhere; }

    /// Adds to `work` what it took, as the others do.
    void remove(std::uint32_t corner, std::uint64_t& work) {
        const std::size_t place = place_of_[corner];
        place_of_[corner] = kNowhere;
        shrink(0, 0, corners_.size(), place, work);
    }

    /// Calls `test` with the corners near a triangle, counter-clockwise, until it returns true. @return whether it did
    template <class Test>
    bool any_near(const std::array<Vec2d, 3>& triangle, std::uint64_t& work, const Test& test) const {
        return !nodes_.empty() && any_below(0, 0, corners_.size(), triangle, work, test);
    }

 private:
    static constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max();
    static constexpr std::size_t kLeaf = 8;
    /// Of twice an area. Coordinates are at most 2: beyond all rounding.
    static constexpr double kSlack = 1e-14;

    /// An empty one is nowhere near anything.
    struct Box {
        Vec2d low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
        Vec2d high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
        void add(Vec2d p) {
            low = {std::min(low.x, p.x), std::min(low.y, p.y)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y)};
        }
        void add(const Box& other) {
            low = {std::min(low.x, other.low.x), std::min(low.y, other.low.y)};
            high = {std::max(high.x, other.high.x), std::max(high.y, other.high.y)};
        }
    };
    /// Of the corners [begin, end); those of up to kLeaf have no children.
    struct Node {
        Box box;
        std::size_t second = 0;  ///< where the second child is; the first one follows its parent
    };

    static std::size_t middle(std::size_t begin, std::size_t end) { return begin + (end - begin) / 2; }

    [[nodiscard]] Box box_of(std::size_t begin, std::size_t end) const {
        Box out;
        for (std::size_t k = begin; k < end; ++k) out.add(points_[corners_[k]]);
        return out;
    }

    std::size_t build(std::size_t begin, std::size_t end) {
        const std::size_t node = nodes_.size();
        nodes_.push_back({box_of(begin, end), 0});
        if (end - begin <= kLeaf) return node;
        const Box box = nodes_[node].box;
        const bool by_x = box.high.x - box.low.x >= box.high.y - box.low.y;
        const auto at = [&](std::size_t k) { return corners_.begin() + static_cast<std::ptrdiff_t>(k); };
        std::nth_element(at(begin), at(middle(begin, end)), at(end), [&](std::uint32_t p, std::uint32_t q) {
            const double a = by_x ? points_[p].x : points_[p].y, b = by_x ? points_[q].x : points_[q].y;
            return a != b ? a < b : p < q;
        });
        build(begin, middle(begin, end));
        const std::size_t second = build(middle(begin, end), end);
        nodes_[node].second = second;
        return node;
    }

    void shrink(std::size_t node, std::size_t begin, std::size_t end, std::size_t place, std::uint64_t& work) {
        Box box;
        if (end - begin <= kLeaf) {
            work += end - begin;
            for (std::size_t k = begin; k < end; ++k)
                if (has(corners_[k])) box.add(points_[corners_[k]]);
        } else {
            ++work;
            const std::size_t half = middle(begin, end), first = node + 1, second = nodes_[node].second;
            if (place < half)
                shrink(first, begin, half, place, work);
            else
                shrink(second, half, end, place, work);
            box.add(nodes_[first].box);
            box.add(nodes_[second].box);
        }
        nodes_[node].box = box;
    }

    /// False only if no corner in the box is in the triangle: the box is beyond one of its sides.
    static bool may_meet(const Box& box, const std::array<Vec2d, 3>& triangle) {
        const auto [left, right] = std::minmax({triangle[0].x, triangle[1].x, triangle[2].x});
        const auto [bottom, top] = std::minmax({triangle[0].y, triangle[1].y, triangle[2].y});
        if (!(box.low.x <= right && box.high.x >= left && box.low.y <= top && box.high.y >= bottom)) return false;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec2d a = triangle[k], b = triangle[(k + 1) % 3], d = b - a;
            const Vec2d innermost{d.y >= 0 ? box.low.x : box.high.x, d.x >= 0 ? box.high.y : box.low.y};
            if (turn(a, b, innermost) < -kSlack) return false;
        }
        return true;
    }

    template <class Test>
    bool any_below(std::size_t node, std::size_t begin, std::size_t end, const std::array<Vec2d, 3>& triangle,
                   std::uint64_t& work, const Test& test) const {
        ++work;
        if (!may_meet(nodes_[node].box, triangle)) return false;
        if (end - begin <= kLeaf) {
            work += end - begin;
            for (std::size_t k = begin; k < end; ++k)
                if (has(corners_[k]) && test(corners_[k])) return true;
            return false;
        }
        const std::size_t half = middle(begin, end);
        return any_below(node + 1, begin, half, triangle, work, test) ||
               any_below(nodes_[node].second, half, end, triangle, work, test);
    }

    std::span<const Vec2d> points_;
    std::vector<std::uint32_t> corners_;
    std::vector<std::size_t> place_of_;  ///< of a corner in corners_; kNowhere once it is removed
    std::vector<Node> nodes_;
};

class EarClipper {
 public:
    /// @param most  point tests that it may take
    EarClipper(std::vector<Vec2d> points, std::uint64_t most)
        : points_(std::move(points)), size_(points_.size()), most_(most) {
        std::vector<std::uint32_t> reflex;
        next_.resize(size_);
        previous_.resize(size_);
        ear_length_.resize(size_);
        for (std::size_t k = 0; k < size_; ++k) {
            next_[k] = static_cast<std::uint32_t>((k + 1) % size_);
            previous_[k] = static_cast<std::uint32_t>((k + size_ - 1) % size_);
        }
        for (std::uint32_t k = 0; k < size_; ++k)
            if (!is_convex_corner(k)) reflex.push_back(k);
        reflex_.emplace(points_, std::move(reflex));
    }

    [[nodiscard]] std::uint64_t work() const { return tests_; }
    /// Corners that became a fan.
    [[nodiscard]] std::size_t fanned() const { return fanned_; }

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
                fanned_ = left;
                return false;
            }
            const std::uint32_t before = previous_[*best], after = next_[*best];
            out.push_back({before, *best, after});
            next_[before] = after;
            previous_[after] = before;
            ear_length_[*best] = kNoEar;
            if (start == *best) start = after;
            --left;
            forget(before, after);
            measure_ear(before);
            measure_ear(after);
        }
        out.push_back({previous_[start], start, next_[start]});
        return true;
    }

 private:
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

    /// Corners only turn convex by clipping, and a clipped one is convex.
    void forget(std::uint32_t before, std::uint32_t after) {
        for (const std::uint32_t k : {before, after})
            if (reflex_->has(k) && is_convex_corner(k)) reflex_->remove(k, tests_);
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
        if (reflex_->any_near({a, b, c}, tests_, lies_inside)) return;
        ear_length_[k] = dot(c - a, c - a);
        ears_.push({ear_length_[k], k});
    }

    std::vector<Vec2d> points_;
    std::size_t size_;
    std::uint64_t most_;
    std::vector<std::uint32_t> next_, previous_;
    std::vector<double> ear_length_;
    std::priority_queue<Ear, std::vector<Ear>, std::greater<>> ears_;
    std::optional<ReflexTree> reflex_;  ///< after the constructor always there
    std::uint64_t tests_ = 0;
    std::size_t fanned_ = 0;
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
        if (std::all_of(corners.begin(), corners.end(), [](const Vec3d& p) { return is_finite(p); }) &&
            !in_line(corners))
            budget.cross(corners.size());
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
    budget.cross(clipper.fanned());
    return done;
}

model::Error crossed_polygons(const std::string& place) {
    return {model::codes::kPolygonCrosses, "polygons of too many corners cross themselves, up to this one", place};
}

}  // namespace dgm::formats
