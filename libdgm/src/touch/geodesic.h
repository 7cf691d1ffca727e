// SPDX-License-Identifier: MIT
// libdgm/src/touch/geodesic.h
// Memory for distances on the rest surface: unfolded triangles and their links, and waiting windows.
//
// A side is an edge as one triangle has it, with a tail and a head. Quad q = i cols + j has the sides
// 8 (q + cols) + 0 .. 5: a-b, b-c, d-c, a-d with corners as in quad_triangles(), then the diagonal as the first and as
// the second triangle have it. Both quads beside an edge name its tail alike. Quads that are not there have sides too:
// that is where ways leave the grid. Triangle f of a free domain's strip has the sides strip + 8 f + 0 .. 2, each from
// one corner to the next.
#pragma once
#include <cstdint>

#include <dgm/state.h>

#include "base/inline.h"
#include "base/memory.h"

namespace dgm::detail {

struct StateImpl;

/// A triangle in the plane: its base from (0, 0) to (1, 0), its apex here. The base is the diagonal of a quad, side 0
/// in a strip. One without any length counts as a millionth of the longer sides.
struct FlatTriangle {
    float x = __builtin_inff();  ///< infinity: no triangle, or one with two corners in one place of the welded surface
    float y = 0;
};

/// Joins a side to the next of the same edge, in a ring: at seams, at strips, and where triangles are missing.
struct SideLink {
    std::uint32_t from = kNone, to = kNone;
    bool turned = false;  ///< the tail of one is the head of the other
};

/// A way through an edge into a triangle, as 2 side + 1 if the head of the side is on the right.
using Way = std::uint32_t;

/// The triangle that a way leads into, relative to the way and its quad.
struct Steps {
    std::int32_t apex, end[2];  ///< samples beyond the edge, and at its right and left end
    std::int32_t out[2];        ///< ways on, across the right and the left edge
    std::int32_t own[2];        ///< the same edges as sides of this triangle
    std::int32_t half;          ///< of the quad: which of its triangles
    float edge[2],
        third[2];  ///< right to left end: edge[0] + edge[1] apex; right end to apex: third[0] + third[1] apex
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
/// A corner that bends ways waits as a Window too: the edge by which the triangle before it was entered, seen from it;
/// the direction it was reached in (right, left); its distance (offset).
inline constexpr Way kBend = 1u << 31;

inline constexpr std::uint8_t kCornerDiagonal = 1;  ///< the quad that starts here is split by diagonal 1
inline constexpr std::uint8_t kCornerLoose = 2;     ///< it has links, or lies beside no quad
inline constexpr std::uint8_t kCornerClass = 4;     ///< in a weld class
inline constexpr std::uint8_t kCornerRim = 8;       ///< of a representative: on an open border
inline constexpr std::uint8_t kCornerBends = 16;    ///< of a representative: shortest ways bend here
inline constexpr std::uint8_t kCornerShort = 32;    ///< of a representative: at the end of a short edge
inline constexpr std::uint8_t kCornerChanged = 64;  ///< of a representative: while ways along edges are looked at

/// Distances stand in FootprintScratch::key, and the samples that have one in FootprintScratch::samples.
struct GeodesicScratch {
    static constexpr std::uint32_t kBuckets = 128, kRecent = 1024;
    Array<FlatTriangle> triangles;  ///< two a quad, then two a triangle of the strip, of which the first counts
    Array<SideLink> links;          ///< a hash table: that of a side stands at hash(side), or at the next free place
    std::uint32_t hash_shift = 31;  ///< links.size() is 2^(32 - hash_shift)
    Array<std::uint8_t> corners;    ///< kCorner* by sample
    Steps steps[2][8][2] = {};      ///< by diagonal, side of the quad, turned
    Steps strip_steps[4][2] = {};   ///< by side, turned; samples are places among the triangle's corners
    std::uint32_t strip = 0;        ///< the first side of the strip
    Array<Window> windows;
    [[nodiscard]] std::uint32_t hash(std::uint32_t side) const noexcept { return (side * 2654435769u) >> hash_shift; }
    std::uint32_t buckets[kBuckets];     ///< by distance: the first window, kNone
    std::uint32_t recent[kRecent] = {};  ///< by way: where a window for it may wait
};

/// Builds all tables. @return false if there is no memory.
[[nodiscard]] bool make_geodesics(StateImpl& state) noexcept;
/// Bytes that make_geodesics() takes at most, besides those by sample (kGeodesicSample).
[[nodiscard]] std::uint64_t geodesic_bytes(std::uint64_t rows, std::uint64_t cols, std::uint64_t face_corners,
                                           std::uint64_t max_reach) noexcept;
inline constexpr std::uint64_t kGeodesicSample = 2 * sizeof(FlatTriangle) + sizeof(std::uint8_t);

}  // namespace dgm::detail
