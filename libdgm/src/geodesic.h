// SPDX-License-Identifier: MIT
// libdgm/src/geodesic.h
// Memory for distances on the rest surface: how each triangle unfolds beside each of its sides, and windows on the way.
//
// A side is an edge as one triangle has it, with a tail and a head. Quad q = i cols + j has the sides
// 8 (q + cols) + 0 .. 5: a-b, b-c, d-c, a-d with corners as in quad_triangles(), then the diagonal as the first and as
// the second triangle have it. Both quads beside an edge name its tail alike. Quads that are not there have sides too:
// that is where ways leave the grid. Triangle f of a free domain's strip has the sides strip + 8 f + 0 .. 2, each from
// one corner to the next.
#pragma once
#include <cstdint>

#include "memory.h"

namespace dgm::detail {

struct StateImpl;

/// The corner of a triangle beyond a side, in lengths of it: from the tail towards the head, and square to that.
struct Apex {
    float along = __builtin_inff();  ///< infinity: no triangle, or a side without length
    float height = 0;
};

/// Joins a side at a seam, at a strip, or of an edge with more than two triangles to the next side of the same edge.
struct SideLink {
    std::uint32_t from, to;
    bool turned;  ///< the tail of one is the head of the other
};

/// A way through an edge, as 2 side + 1 if the head of the side is on the right.
using Way = std::uint32_t;

/// Ways out of a triangle, from the one in. 0: across the right edge, 1: across the left one.
struct Steps {
    std::int32_t apex, end[2];  ///< samples, from that of the quad; ends of the edge of the way in: right, left
    std::int32_t out[2];        ///< way into the triangle beyond
    std::int32_t own[2];        ///< way out, as this triangle has the side
};

/// Straight lines from a source at the origin of a plane into which all triangles on the way are laid, where they cross
/// the edge of the next triangle.
struct Window {
    float ax, ay;        ///< right end of the edge, kernel steps
    float ex, ey;        ///< from there to its left end
    float right, left;   ///< outermost lines, 0 .. 1 along the edge
    float offset;        ///< from the contact to the source
    Way way;             ///< kNone: free
    std::uint32_t next;  ///< in its bucket, or of the free ones
};
/// A corner that bends ways waits as a Window: the edge by which the triangle before it was entered, seen from it; the
/// direction it was reached in (right, left); its distance (offset).
inline constexpr Way kBend = 1u << 31;

inline constexpr std::uint8_t kCornerDiagonal = 1;  ///< the quad that starts here is split by diagonal 1
inline constexpr std::uint8_t kCornerClass = 2;     ///< in a seam class
inline constexpr std::uint8_t kCornerRim = 4;       ///< of a representative: on an open border
inline constexpr std::uint8_t kCornerBends = 8;     ///< of a representative: shortest ways bend here
inline constexpr std::uint8_t kCornerChanged = 16;  ///< of a representative: while ways along edges are looked at

struct GeodesicScratch {
    static constexpr std::uint32_t kBuckets = 128, kRecent = 1024, kSides = 6;
    Array<Apex> apex;  ///< at place_of(side)
    [[nodiscard]] static std::uint32_t place_of(std::uint32_t side) noexcept { return (side >> 3) * kSides + (side & 7); }
    Array<SideLink> links;
    Steps steps[2][8][2] = {};        ///< by diagonal, side of the quad, turned
    std::uint32_t strip = 0;          ///< the first side of the strip
    Array<std::uint8_t> corners;      ///< kCorner* by sample
    Array<float> distance;            ///< by sample; infinity between calls
    Array<std::uint32_t> touched;     ///< samples with a distance
    std::uint32_t touched_count = 0;
    Array<Window> windows;
    std::uint32_t buckets[kBuckets];  ///< by distance: the first window, kNone
    std::uint32_t recent[kRecent] = {};  ///< by way: where a window for it may wait
};

/// Builds all tables. @return false if there is no memory.
[[nodiscard]] bool make_geodesics(StateImpl& state) noexcept;
/// Bytes that make_geodesics() takes at most, besides those by sample (kGeodesicSample).
[[nodiscard]] std::uint64_t geodesic_bytes(std::uint64_t rows, std::uint64_t cols, std::uint64_t face_corners,
                                           std::uint64_t max_reach) noexcept;
inline constexpr std::uint64_t kGeodesicSample = GeodesicScratch::kSides * sizeof(Apex) + sizeof(std::uint8_t) + 2 * sizeof(float);

}  // namespace dgm::detail
