// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/polygon.cpp
// [Meisters 1975] Meisters. Polygons have ears. American Mathematical Monthly 82, 1975.
#include "mesh/polygon.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dgm::formats {
namespace {

using model::Vec2d;
using model::Vec3d;

constexpr std::uint64_t kMaxPointTests = std::uint64_t{1} << 28;

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

class EarClipper {
 public:
    explicit EarClipper(std::vector<Vec2d> points) : points_(std::move(points)), size_(points_.size()) {
        next_.resize(size_);
        previous_.resize(size_);
        ear_length_.resize(size_);
        for (std::size_t k = 0; k < size_; ++k) {
            next_[k] = static_cast<std::uint32_t>((k + 1) % size_);
            previous_[k] = static_cast<std::uint32_t>((k + size_ - 1) % size_);
        }
    }

    bool run(std::vector<CornerTriple>& out) {
        std::size_t left = size_;
        std::uint32_t start = 0;
        for (std::uint32_t k = 0; k < size_; ++k)
            if (!is_convex_corner(k)) reflex_.push_back(k);
        for (std::uint32_t k = 0; k < size_; ++k) measure_ear(k);
        while (left > 3) {
            std::uint32_t best = best_ear(start, left);
            if (!std::isfinite(ear_length_[best])) {
                // Clipping a far ear can free another one, so look again before giving up.
                for (std::uint32_t k = start, seen = 0; seen < left; k = next_[k], ++seen) measure_ear(k);
                best = best_ear(start, left);
            }
            if (!std::isfinite(ear_length_[best]) || tests_ > kMaxPointTests) {
                std::vector<std::uint32_t> loop;
                for (std::uint32_t k = start, seen = 0; seen < left; k = next_[k], ++seen) loop.push_back(k);
                append_fan(loop, out);
                return false;
            }
            const std::uint32_t before = previous_[best], after = next_[best];
            out.push_back({before, best, after});
            next_[before] = after;
            previous_[after] = before;
            if (start == best) start = after;
            --left;
            // Corners only turn convex by clipping, and a clipped one is no obstacle.
            std::erase_if(reflex_, [&](std::uint32_t k) {
                return k == best || ((k == before || k == after) && is_convex_corner(k));
            });
            measure_ear(before);
            measure_ear(after);
        }
        out.push_back({previous_[start], start, next_[start]});
        return true;
    }

 private:
    [[nodiscard]] bool is_convex_corner(std::uint32_t k) const {
        return turn(points_[previous_[k]], points_[k], points_[next_[k]]) > 0;
    }

    std::uint32_t best_ear(std::uint32_t start, std::size_t left) {
        std::uint32_t best = start;
        std::uint32_t k = start;
        for (std::size_t seen = 0; seen < left; ++seen, k = next_[k])
            if (ear_length_[k] < ear_length_[best]) best = k;
        tests_ += left;
        return best;
    }

    /// Squared length of the diagonal that cuts off corner k; infinite if k is no ear.
    void measure_ear(std::uint32_t k) {
        ear_length_[k] = std::numeric_limits<double>::infinity();
        if (!is_convex_corner(k) || tests_ > kMaxPointTests) return;
        const std::uint32_t ia = previous_[k], ic = next_[k];
        const Vec2d a = points_[ia], b = points_[k], c = points_[ic];
        tests_ += reflex_.size();
        // If any corner lies inside, a reflex one does.
        for (const std::uint32_t q : reflex_) {
            if (q == ia || q == ic) continue;
            const Vec2d p = points_[q];
            // A corner that lies on one of a, b, c (a slit or bridge) does not spoil the ear by itself.
            if (p == a || p == b || p == c) continue;
            if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return;
        }
        ear_length_[k] = dot(c - a, c - a);
    }

    std::vector<Vec2d> points_;
    std::size_t size_;
    std::vector<std::uint32_t> next_, previous_, reflex_;
    std::vector<double> ear_length_;
    std::uint64_t tests_ = 0;
};

bool is_convex(std::span<const Vec2d> p) {
    for (std::size_t k = 0; k < p.size(); ++k)
        if (!(turn(p[k], p[(k + 1) % p.size()], p[(k + 2) % p.size()]) > 0)) return false;
    return true;
}

}  // namespace

bool triangulate_polygon(std::span<const Vec3d> corners, std::vector<CornerTriple>& out) {
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
    return EarClipper(std::move(flat)).run(out);
}

}  // namespace dgm::formats
