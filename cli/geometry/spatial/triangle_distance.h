// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/spatial/triangle_distance.h
// Distance from a point to a triangle, equal to the bit on an edge from either side.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "geometry/mesh/infinity.h"
#include "model/vec.h"

namespace dgm::bake {

// Squared sine under which a triangle is treated as its three edges; the error is then below 1e-10 of its longest edge.
inline constexpr double kSliverSineSquared = 1e-20;

inline constexpr std::uint32_t kNoTriangle = std::numeric_limits<std::uint32_t>::max();

/// A triangle of an index, in the index's frame.
struct Triangle {
    model::Vec3d a, b, c;
    model::Vec3d normal;    // (b - a) x (c - a), not normalised; zero if the triangle is a sliver
    double normal_squared;  // 0 if the triangle is a sliver
    std::uint32_t face;
    bool swap_ab, swap_bc, swap_ca;  // the edge's second vertex has the lower index
};

/// The triangle's corners from the longest edge's start on.
inline std::array<model::Vec3d, 3> from_longest_edge(const Triangle& tri) {
    const double ab = length(tri.b - tri.a), bc = length(tri.c - tri.b), ca = length(tri.a - tri.c);
    if (ab >= bc && ab >= ca) return {tri.a, tri.b, tri.c};
    if (bc >= ca) return {tri.b, tri.c, tri.a};
    return {tri.c, tri.a, tri.b};
}

/// The nearest point so far, of whichever triangles were visited.
struct Nearest {
    double squared = kInfinity;
    std::uint32_t face = kNoTriangle, triangle = kNoTriangle;
    model::Vec3d point;
    std::array<double, 3> barycentric{};
};

/// Nearest point of segment (a, b), with t its parameter from a; walks from b if `swap`, so both users get equal bits.
inline double segment_distance(const model::Vec3d& p, const model::Vec3d& a, const model::Vec3d& b, bool swap,
                               model::Vec3d& point, double& t) {
    const model::Vec3d& from = swap ? b : a;
    const model::Vec3d& to = swap ? a : b;
    const model::Vec3d edge = to - from;
    const double along = dot(p - from, edge), squared = dot(edge, edge);
    double s;
    if (!(along > 0)) {
        s = 0;
        point = from;
    } else if (along >= squared) {
        s = 1;
        point = to;
    } else {
        s = along / squared;
        point = from + edge * s;
    }
    t = swap ? 1 - s : s;
    const model::Vec3d d = p - point;
    return dot(d, d);
}

/// Squared distance from p to the triangle, with the nearest point and its barycentric coordinates.
///
/// The signs of the three edge sides decide the region, as in [Ericson 2005, section 5.1.5], but taken as
/// n . (edge x (p - corner)): their error is a lateral shift of about 1e-16 |p - corner|, whatever the triangle's size.
/// Outside, the nearest point lies on an edge that has p on its outer side.
inline double triangle_distance(const Triangle& tri, const model::Vec3d& p, model::Vec3d& point,
                                std::array<double, 3>& bary) {
    bool test_ab = true, test_bc = true, test_ca = true;
    if (tri.normal_squared > 0) {
        const model::Vec3d ap = p - tri.a, bp = p - tri.b, cp = p - tri.c;
        const double side_ab = dot(tri.normal, cross(tri.b - tri.a, ap));
        const double side_bc = dot(tri.normal, cross(tri.c - tri.b, bp));
        const double side_ca = dot(tri.normal, cross(tri.a - tri.c, cp));
        if (side_ab >= 0 && side_bc >= 0 && side_ca >= 0) {
            const double sum = side_ab + side_bc + side_ca;
            if (sum > 0) {
                bary = {side_bc / sum, side_ca / sum, side_ab / sum};
                point = tri.a + (tri.b - tri.a) * bary[1] + (tri.c - tri.a) * bary[2];
                const model::Vec3d d = p - point;
                return dot(d, d);
            }
        } else {
            test_ab = side_ab < 0;
            test_bc = side_bc < 0;
            test_ca = side_ca < 0;
        }
    }
    double best = kInfinity;
    model::Vec3d q;
    double t = 0;
    if (test_ab) {
        best = segment_distance(p, tri.a, tri.b, tri.swap_ab, point, t);
        bary = {1 - t, t, 0};
    }
    if (test_bc) {
        const double squared = segment_distance(p, tri.b, tri.c, tri.swap_bc, q, t);
        if (squared < best) {
            best = squared;
            point = q;
            bary = {0, 1 - t, t};
        }
    }
    if (test_ca) {
        const double squared = segment_distance(p, tri.c, tri.a, tri.swap_ca, q, t);
        if (squared < best) {
            best = squared;
            point = q;
            bary = {t, 0, 1 - t};
        }
    }
    return best;
}

/// True if the plane alone shows that the triangle is farther than `squared`. The margin covers rounding.
inline bool plane_is_farther(const Triangle& tri, const model::Vec3d& p, double squared) {
    const double height = dot(tri.normal, p - tri.a);
    return height * height > squared * tri.normal_squared * (1 + 1e-4) + 1e-30 * tri.normal_squared &&
           tri.normal_squared > 0;
}

}  // namespace dgm::bake
