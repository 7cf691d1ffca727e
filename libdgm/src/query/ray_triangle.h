// SPDX-License-Identifier: MIT
// libdgm/src/query/ray_triangle.h
// Tests one ray against one triangle or box, so that nothing slips between triangles and no box hides one.
//
// [Woop 2013] Woop, Benthin, Wald. Watertight Ray/Triangle Intersection. JCGT 2(1), 2013. Names follow the paper: kz is
// the largest axis of the direction, S the shear that turns the ray into the z axis, U, V, W the edge functions.
// Our choices, where the paper has float with a double fallback:
// - Double from the start. Coordinates are floats, multiples of 2^-149 below 2^128; so sheared ones are 0 or within
//   2^-426 .. 2^130, products of two within 2^-852 .. 2^260, and their rounding errors above 2^-958: nothing overflows,
//   and nothing underflows, for any floats.
// - An edge function whose products round to the same double is the difference of their rounding errors, which fma
//   gives exactly. Unequal products round monotonically. So every sign is that of exact arithmetic on the sheared
//   corners; two triangles at an edge see opposite signs, or both 0 and then both hold the ray.
// - The depth is clamped to those of the corners, where it lies but for rounding.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "touch/state_impl.h"

namespace dgm::detail {

struct Ray {
    double origin[3];       ///< along kx, ky, kz
    std::uint32_t axis[3];  ///< kx, ky, kz: a turn of x, y, z, so that no triangle is mirrored
    double shear[2];        ///< d_kx / d_kz, d_ky / d_kz; at most 1
    double sign;            ///< of d_kz
    double scale;           ///< |d| / |d_kz|: from depth to distance
};

/// A sample in the ray's coordinates: the ray is the line x = y = 0, `depth` grows along it.
struct Sheared {
    double x, y, depth;
};

/// Direction finite and not 0, origin finite.
inline Ray make_ray(Vec3 origin, Vec3 direction) noexcept {
    const double o[3] = {origin.x, origin.y, origin.z}, d[3] = {direction.x, direction.y, direction.z};
    std::uint32_t kz = 0;
    for (std::uint32_t k = 1; k < 3; ++k)
        if (std::fabs(d[k]) > std::fabs(d[kz])) kz = k;
    const std::uint32_t kx = (kz + 1) % 3, ky = (kz + 2) % 3;
    const double sx = d[kx] / d[kz], sy = d[ky] / d[kz];
    return {{o[kx], o[ky], o[kz]}, {kx, ky, kz}, {sx, sy}, d[kz] < 0 ? -1.0 : 1.0, std::sqrt(sx * sx + sy * sy + 1)};
}

/// Planes in the order of the ray's axes.
struct RayPlanes {
    const float* k[3];
};
inline RayPlanes planes_of(const Ray& ray, const ConstPlanes& p) noexcept {
    const float* const planes[3] = {p.x, p.y, p.z};
    return {{planes[ray.axis[0]], planes[ray.axis[1]], planes[ray.axis[2]]}};
}

inline Sheared shear(const Ray& ray, const RayPlanes& p, std::uint32_t sample) noexcept {
    const double z = double{p.k[2][sample]} - ray.origin[2];
    return {(double{p.k[0][sample]} - ray.origin[0]) - ray.shear[0] * z,
            (double{p.k[1][sample]} - ray.origin[1]) - ray.shear[1] * z, ray.sign * z};
}

/// x_p y_q - y_p x_q, of the exact sign; edge(q, p) is -edge(p, q) to the bit.
inline double edge(const Sheared& p, const Sheared& q) noexcept {
    const double a = p.x * q.y, b = p.y * q.x;
    if (a != b) return a - b;
    return std::fma(p.x, q.y, -a) - std::fma(p.y, q.x, -b);
}

/// Result of the test for a triangle that is hit.
struct TriangleHit {
    double distance;   ///< local units
    double weight[3];  ///< barycentric coordinates
    bool front;        ///< the triangle turns counter-clockwise as seen from the origin
};

/// @return whether the ray's line passes through the triangle at a distance from 0.
inline bool meets(const Ray& ray, const Sheared& a, const Sheared& b, const Sheared& c, TriangleHit& hit) noexcept {
    const double u = edge(b, c), v = edge(c, a), w = edge(a, b);
    if (!(u >= 0 && v >= 0 && w >= 0) && !(u <= 0 && v <= 0 && w <= 0)) return false;
    const double area = u + v + w;
    if (area == 0) return false;
    const double low = std::min(std::min(a.depth, b.depth), c.depth);
    const double high = std::max(std::max(a.depth, b.depth), c.depth);
    const double depth = (u * a.depth + v * b.depth + w * c.depth) / area;
    const double distance = std::min(std::max(depth, low), high) * ray.scale;
    if (!(distance >= 0)) return false;
    hit.distance = distance;
    hit.weight[0] = u / area;
    hit.weight[1] = v / area;
    hit.weight[2] = w / area;
    // The area's sign is that of normal . direction / d_kz.
    hit.front = (area < 0) == (ray.sign > 0);
    return true;
}

/// Lower bound of the distance of every hit in a box; infinite if there can be none.
///
/// Proof: each coordinate of shear() is made of roundings of monotone functions of the stored floats, so for a sample
/// in the box it lies between the values below, which are rounded alike. A triangle is hit only if the origin lies in
/// the hull of its sheared corners, exactly, so 0 lies between the least and the largest x, and y, of the box. A hit's
/// depth is clamped to its corners', thus to the box's, and times a constant is monotone too.
inline double box_near(const Ray& ray, const Box& box) noexcept {
    constexpr double kNever = __builtin_inf();
    const double z0 = double{box.low[ray.axis[2]]} - ray.origin[2], z1 = double{box.high[ray.axis[2]]} - ray.origin[2];
    if (!(z0 <= z1)) return kNever;  // an empty box
    for (int k = 0; k < 2; ++k) {
        const double low = double{box.low[ray.axis[k]]} - ray.origin[k];
        const double high = double{box.high[ray.axis[k]]} - ray.origin[k];
        const double s0 = ray.shear[k] * z0, s1 = ray.shear[k] * z1;
        if (low - std::max(s0, s1) > 0 || high - std::min(s0, s1) < 0) return kNever;
    }
    const double near = ray.sign > 0 ? z0 : -z1, far = ray.sign > 0 ? z1 : -z0;
    return far < 0 ? kNever : std::max(near, 0.0) * ray.scale;
}

}  // namespace dgm::detail
