// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/triangle.h
// Measures a triangle: area, normal, longest edge, distance to a point.
//
// Results of a bake depend on these to the last bit: an expression that looks equal may round differently.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "model/vec.h"

namespace dgm::bake {

using model::Vec2d;
using model::Vec3d;

[[nodiscard]] inline double face_area(const std::array<Vec3d, 3>& q) {
    return 0.5 * length(cross(q[1] - q[0], q[2] - q[0]));
}

/// Sums the faces of a TriMesh, or of anything else with `faces` and `corners(face)`, in their order.
template <class Surface>
[[nodiscard]] double surface_area(const Surface& surface) {
    double sum = 0;
    for (std::size_t f = 0; f < surface.faces.size(); ++f) sum += face_area(surface.corners(f));
    return sum;
}

/// Area in the map; negative where the triangle is inverted.
[[nodiscard]] inline double signed_area(const Vec2d& a, const Vec2d& b, const Vec2d& c) {
    return 0.5 * cross(b - a, c - a);
}

/// Unit normal; zero for a triangle without area.
[[nodiscard]] inline Vec3d unit_normal(const std::array<Vec3d, 3>& q) {
    return normalized(cross(q[1] - q[0], q[2] - q[0]), Vec3d{});
}

[[nodiscard]] inline double longest_edge_squared(const std::array<Vec3d, 3>& q) {
    const Vec3d a = q[1] - q[0], b = q[2] - q[1], c = q[0] - q[2];
    return std::max({dot(a, a), dot(b, b), dot(c, c)});
}

/// Squared distance from p to the segment from a along e, and the share of e where the closest point lies.
inline double closest_on_segment(const Vec3d& p, const Vec3d& a, const Vec3d& e, double& t) {
    const Vec3d v = p - a;
    const double l = dot(e, e);
    t = l > 0 ? std::clamp(dot(v, e) / l, 0.0, 1.0) : 0.0;
    const Vec3d r = v - e * t;
    return dot(r, r);
}

/// Squared distance from p to a triangle and the barycentric coordinates of the closest point; faces without area count
/// as their edges. Exact enough for triangles of ordinary shape; ClosestPointIndex (spatial/closest_point.h) is exact
/// for needles too.
inline double closest_on_triangle(const Vec3d& p, const std::array<Vec3d, 3>& q, std::array<double, 3>& b) {
    const Vec3d e0 = q[1] - q[0], e1 = q[2] - q[0], d = p - q[0];
    const double g00 = dot(e0, e0), g01 = dot(e0, e1), g11 = dot(e1, e1), r0 = dot(e0, d), r1 = dot(e1, d);
    const double det = g00 * g11 - g01 * g01, s = g11 * r0 - g01 * r1, t = g00 * r1 - g01 * r0;
    if (det > 0 && s >= 0 && t >= 0 && s + t <= det) {
        const double u = s / det, v = t / det;
        b = {1 - u - v, u, v};
        const Vec3d r = d - e0 * u - e1 * v;
        return dot(r, r);
    }
    // Outside: on an edge that has p on its outer side (any of the three without area).
    double best = INFINITY, x = 0;
    const auto offer = [&](double squared, const std::array<double, 3>& at) {
        if (squared < best) {
            best = squared;
            b = at;
        }
    };
    if (!(t > 0) || !(det > 0)) {
        const double squared = closest_on_segment(p, q[0], e0, x);
        offer(squared, {1 - x, x, 0});
    }
    if (!(s > 0) || !(det > 0)) {
        const double squared = closest_on_segment(p, q[0], e1, x);
        offer(squared, {1 - x, 0, x});
    }
    if (!(s + t < det) || !(det > 0)) {
        const double squared = closest_on_segment(p, q[1], q[2] - q[1], x);
        offer(squared, {0, 1 - x, x});
    }
    return best;
}

/// A triangle that many points are measured to: the squared distances of closest_on_triangle(), bit for bit.
class PreparedTriangle {
 public:
    PreparedTriangle() = default;
    explicit PreparedTriangle(const std::array<Vec3d, 3>& q)
        : a_(q[0]),
          b_(q[1]),
          e0_(q[1] - q[0]),
          e1_(q[2] - q[0]),
          e2_(q[2] - q[1]),
          g00_(dot(e0_, e0_)),
          g01_(dot(e0_, e1_)),
          g11_(dot(e1_, e1_)),
          g22_(dot(e2_, e2_)),
          det_(g00_ * g11_ - g01_ * g01_) {}

    [[nodiscard]] double squared_distance(const Vec3d& p) const {
        const Vec3d d = p - a_;
        const double r0 = dot(e0_, d), r1 = dot(e1_, d), s = g11_ * r0 - g01_ * r1, t = g00_ * r1 - g01_ * r0;
        if (det_ > 0 && s >= 0 && t >= 0 && s + t <= det_) {
            const Vec3d r = d - e0_ * (s / det_) - e1_ * (t / det_);
            return dot(r, r);
        }
        double best = INFINITY;
        if (!(t > 0) || !(det_ > 0)) best = std::min(best, to_segment(d, e0_, g00_));
        if (!(s > 0) || !(det_ > 0)) best = std::min(best, to_segment(d, e1_, g11_));
        if (!(s + t < det_) || !(det_ > 0)) best = std::min(best, to_segment(p - b_, e2_, g22_));
        return best;
    }

 private:
    /// @param v  from the segment's start to the point
    static double to_segment(const Vec3d& v, const Vec3d& e, double squared_length) {
        const double t = squared_length > 0 ? std::clamp(dot(v, e) / squared_length, 0.0, 1.0) : 0.0;
        const Vec3d r = v - e * t;
        return dot(r, r);
    }

    Vec3d a_, b_, e0_, e1_, e2_;
    double g00_ = 0, g01_ = 0, g11_ = 0, g22_ = 0, det_ = 0;
};

/// Some unit vector at right angles to `v`; the same for the same `v`.
[[nodiscard]] inline Vec3d any_perpendicular(const Vec3d& v) {
    return normalized(cross(v, std::abs(v.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
}

}  // namespace dgm::bake
