// SPDX-License-Identifier: MIT
// libdgm/src/geodesic.h
// Tables for distances on the rest surface: how each triangle unfolds beside each of its sides.
//
// A side is an edge as one triangle has it. Quad q, named by its corner sample (i, j) plus one row, has the sides
// 8 q + 0 .. 5: 0 a-b, 1 b-c, 2 d-c, 3 a-d as in quad_triangles(), and 4 and 5 the diagonal of the first and of the
// second triangle. A side leads from its tail to its head, in that order here. The rows of quads before the first and
// after the last, and those of the last column, have no triangles: a side there is where a way leaves the grid.
// Triangle f of a free domain's strip has the sides strip + 4 f + 0 .. 2, from each corner to the next.
#pragma once
#include <cstdint>

#include "memory.h"

namespace dgm::detail {

struct StateImpl;

/// The corner beyond a side: tail + along * (head - tail) + height * the same turned by a quarter, away from where the
/// way comes from.
struct Apex {
    float along = __builtin_inff();  ///< infinity: no triangle, or a side without length
    float height = 0;
};

/// Joins a side at a seam, at a strip or at more than two triangles to the next side of the same edge, in a ring.
struct SideLink {
    std::uint32_t from, to;
    bool turned;  ///< tail meets head
};

/// A way out of a triangle.
struct SideExit {
    std::int32_t own;    ///< side of this triangle, from the one the way came in by
    std::int32_t other;  ///< the same edge in the triangle beyond
    bool turned;         ///< the edge is left with its head to the right
};
struct SideSteps {
    std::int32_t apex;  ///< sample, from that of the quad
    SideExit exit[2];   ///< right, left
};

/// A pencil of straight lines from a source that lies at the origin of a plane into which all triangles on the way are
/// laid, at the edge where it is about to enter one more.
struct Window {
    float ax, ay;       ///< right end of the edge, steps
    float ex, ey;       ///< from there to its left end
    float right, left;  ///< where the outermost lines cross it, 0 .. 1
    float offset;       ///< distance of the source from the contact
    std::uint32_t to;   ///< side of the triangle to enter; times two, plus one if it is turned
    std::uint32_t next; ///< in its bucket, or of the free ones
};

inline constexpr std::uint8_t kCornerDiagonal = 1;  ///< the quad that starts here is split by diagonal 1
inline constexpr std::uint8_t kCornerClass = 2;     ///< in a seam class
inline constexpr std::uint8_t kCornerRim = 4;       ///< of a representative: on an open border
inline constexpr std::uint8_t kCornerBends = 8;     ///< of a representative: shortest ways may bend here

struct GeodesicScratch {
    Array<Apex> apex;  ///< by side
    Array<SideLink> links;
    SideSteps steps[2][6][2] = {};   ///< diagonal, side, turned
    Array<std::uint8_t> corners;     ///< kCorner* by sample
    std::uint32_t strip = 0;         ///< the first side of the strip
    Array<float> distance;           ///< by sample, infinity between calls
    Array<std::uint32_t> touched;
    static constexpr std::uint32_t kBuckets = 128, kRecent = 1024;
    Array<Window> windows;
    std::uint32_t buckets[kBuckets] = {};  ///< first window of each, kNone
    std::uint32_t recent[kRecent] = {};    ///< by side: a window that may still wait there
    std::uint32_t touched_count = 0;
};

/// Builds all tables. @return false if there is no memory.
[[nodiscard]] bool make_geodesics(StateImpl& state) noexcept;
/// Windows a state keeps memory for.
[[nodiscard]] std::uint64_t window_capacity(std::uint64_t max_reach) noexcept;

}  // namespace dgm::detail
