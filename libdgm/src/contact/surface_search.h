// SPDX-License-Identifier: MIT
// libdgm/src/contact/surface_search.h
// The triangle of an obstacle's surface that is nearest to a point.
#pragma once
#include <array>
#include <cstdint>
#include <limits>

#include "base/inline.h"
#include "contact/contact_impl.h"

namespace dgm::detail {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A triangle whose nearest point is one of the nearest of all.
struct Hit {
    double square = kInfinity;
    double facing = 0;  ///< n . (p - nearest), n the triangle's unit normal; 0 without area
    double rank = -1;   ///< |facing|, -1 without area
    Double3 nearest;
    /// 2 k + t: triangle t of the quad at sample k; border faces from 2 total on.
    std::uint64_t triangle = kNoTriangle;

    /// The order among triangles as near: the one that faces the point most, then the first.
    [[nodiscard]] bool before(const Hit& other) const noexcept {
        return rank != other.rank ? rank > other.rank : triangle < other.triangle;
    }
};
DGM_INLINE Double3 to_own(const Shape& o, Double3 p) noexcept {
    const Double3 v = p - o.point;
    return {dot(o.axis[0], v), dot(o.axis[1], v), dot(o.axis[2], v)};
}
DGM_INLINE Double3 from_own(const Shape& o, Double3 p) noexcept {
    return o.point + p.x * o.axis[0] + p.y * o.axis[1] + p.z * o.axis[2];
}

/// low <= high in each coordinate.
[[nodiscard]] inline bool holds(Double3 low, Double3 high) noexcept {
    return low.x <= high.x && low.y <= high.y && low.z <= high.z;
}
/// Corners of a triangle by Hit::triangle.
[[nodiscard]] DGM_API std::array<std::uint32_t, 3> corners_of(const Surface& surface, std::uint64_t name) noexcept;

/// The nearest triangle to p, in the surface's own coordinates, by its box pyramid. The answer is a function of the
/// point and the triangles alone: `hint`, a triangle that may be near, and Shape::near save time only.
[[nodiscard]] Hit search_surface(const Shape& obstacle, Double3 p, std::uint64_t hint) noexcept;

}  // namespace dgm::detail
