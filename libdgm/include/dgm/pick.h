// SPDX-License-Identifier: MIT
// libdgm/include/dgm/pick.h
// Finds what a ray meets first: a mouse over the picture, a needle, a line of sight.
#pragma once
#include <cstdint>
#include <limits>

#include <dgm/result.h>
#include <dgm/state.h>
#include <dgm/vec.h>

namespace dgm {

struct PickOptions {
    float max_distance = std::numeric_limits<float>::infinity();  ///< local units, >= 0; hits just there count
    bool back_faces = true;  ///< false: triangles seen from the side that their normals point away from are passed
};

/// The triangle that a ray meets first.
struct RayHit {
    /// Corner with the largest barycentric coordinate, of equal ones the first in `corners`. A seam sample is named by
    /// its class's representative, as in nearest_sample().
    std::uint32_t sample = kNone;
    std::uint32_t row = kNone, column = kNone;  ///< quad (i, j); kNone for a face of a free domain's border strip
    std::uint32_t triangle = 0;     ///< 0 or 1, as quad_triangles() orders them; else the place in `border_faces`
    std::uint32_t corners[3] = {};  ///< samples as the triangle has them: seam copies are not renamed
    float barycentric[3] = {};      ///< weights of the corners, each in 0 .. 1, of sum 1 but for rounding
    float distance = 0;             ///< from the origin to the point, local units, whatever the direction's length
    Vec3 point;                     ///< local coordinates, from the corners by `barycentric` in double
    Vec3 normal;                    ///< unit normal of the flat triangle, same side as State::normals()
    bool front = false;             ///< seen from the side that `normal` points to
};

/// First triangle of the present shape along a ray, border strips of free domains included.
///
/// The triangle test is the watertight one of Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", Journal
/// of Computer Graphics Techniques 2(1), 2013, in double with exact signs: through edges, corners and seams of a closed
/// surface no ray slips. A ray in a triangle's own plane meets that triangle's neighbours, not it. The answer is, to
/// the bit, that of the same test on all triangles: boxes are tested in the sheared coordinates of the triangles, where
/// rounding is monotone and no slack is needed. Of equally near triangles the first wins: quads row by row, then the
/// border strip.
///
/// Boxes of tiles touched since the last query are refitted first, hence the non-const state.
/// @param origin, direction  local coordinates, any finite numbers; the direction need not be of length 1. From 1e15
///        times the surface's size its samples round to one place, and nothing is met.
/// @return NotFound if nothing is met within max_distance; BadArgument if a number is not finite, the direction is 0
///         or max_distance is negative or NaN. A distance beyond float is given as the largest float.
/// No allocation, no locks. O(log samples) for most rays; one that grazes the surface looks at all tiles along it.
[[nodiscard]] DGM_API Result<RayHit> pick_ray(State& state, Vec3 origin, Vec3 direction,
                                              const PickOptions& options = {}) noexcept;

}  // namespace dgm
