// SPDX-License-Identifier: MIT
// libdgm/include/dgm/pick.h
// Finds the triangle that a ray meets first: for a mouse over the picture, a needle, a line of sight.
#pragma once
#include <cstdint>
#include <limits>

#include <dgm/result.h>
#include <dgm/state.h>
#include <dgm/vec.h>

namespace dgm {

/// Limits of a ray.
struct PickOptions {
    float max_distance = std::numeric_limits<float>::infinity();  ///< local units, >= 0; hits at this distance count
    bool back_faces = true;  ///< false: ignore triangles seen from the side that their normals point away from
};

/// The triangle that a ray meets first.
struct RayHit {
    /// Corner with the largest barycentric coordinate; the first in `corners` if several are equal. A seam sample is
    /// named by the representative of its weld class, as in nearest_sample().
    std::uint32_t sample = kNone;
    std::uint32_t row = kNone, column = kNone;  ///< quad (i, j); kNone for a face of a free domain's border strip
    std::uint32_t triangle = 0;     ///< 0 or 1, as quad_triangles() orders them; else the row of `border_faces`
    std::uint32_t corners[3] = {};  ///< samples as the triangle has them: seam copies keep their own index
    float barycentric[3] = {};      ///< weights of the corners, each in 0 .. 1; their sum is 1 up to rounding
    float distance = 0;             ///< from the origin to the point, local units, whatever the direction's length
    Vec3 point;                     ///< local coordinates, computed from the corners and `barycentric` in double
    Vec3 normal;                    ///< unit normal of the flat triangle, same side as State::normals()
    bool front = false;             ///< seen from the side that `normal` points to
};

/// Finds the first triangle of the present shape along a ray, border strips of free domains included.
///
/// The triangle test is the watertight one of Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", Journal
/// of Computer Graphics Techniques 2(1), 2013, in double with exact signs: no ray slips through an edge, a corner or a
/// seam of a closed surface. A ray in a triangle's own plane meets the neighbours of that triangle, not it. The answer
/// has the bits of the same test on all triangles: boxes are tested in the sheared coordinates of the triangles, where
/// rounding is monotone and no slack is needed. If several triangles are equally near, the first wins: quads row by
/// row, then the border strip.
///
/// Boxes of tiles touched since the last query are refitted first, hence the non-const state.
/// @param origin, direction  local coordinates, any finite numbers; the direction need not be of length 1. From a
///        distance of 1e15 times the surface's size, its samples round to one place, and nothing is met.
/// @return NotFound if no triangle is met within max_distance; BadArgument if a number is not finite, the direction is
///         0 or max_distance is negative or NaN. A distance beyond float is given as the largest float.
/// No allocation, no locks. O(log samples) for most rays; one that grazes the surface visits all tiles along it.
[[nodiscard]] DGM_API Result<RayHit> pick_ray(State& state, Vec3 origin, Vec3 direction,
                                              const PickOptions& options = {}) noexcept;

}  // namespace dgm
