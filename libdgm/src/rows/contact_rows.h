// SPDX-License-Identifier: MIT
// libdgm/src/rows/contact_rows.h
// Inner loops of a contact, built once per instruction set as rows.h is.
//
// Projecting, weighing and bulging round alike in all variants and lanes, so copies of a class agree; sums differ in
// their order.
#pragma once
#include <cstdint>

#include "rows/rows.h"

namespace dgm::detail {

inline constexpr std::uint8_t kQuadNone = 2;  ///< else 0 or 1, the diagonal

/// Quads (i, j) of `rect`, clipped so that all have four corners in the grid.
struct QuadJob {
    Rect rect;
    std::uint32_t cols;
    ConstPlanes at;
    const std::uint8_t* kind;
    double origin[3];
};

enum class Beyond : std::uint32_t { kPlane, kRound };

/// Samples against a plane, or against all that is nearer than a radius to a segment or a point.
struct MarkJob {
    Rect rect;
    std::uint32_t cols;
    ConstPlanes at;
    Beyond kind;
    double a[3];      ///< plane: the unit normal; round: an end of the segment
    double along[3];  ///< round: from there to the other end
    double square;    ///< round: along . along; 1 where that is 0
    double d;         ///< plane: n . p - d is the distance; round: the radius
    double tolerance;
    const std::uint8_t* skip;  ///< not 0: a sample that is left alone
    std::uint8_t* marks;       ///< out: bit 0 where beyond
    Planes to;                 ///< out: where those come out
};

struct MarkSums {
    std::uint32_t count = 0;
    double deepest = 0, total = 0;
};

struct WeightJob {
    Rect rect;
    std::uint32_t cols;
    const float* square;    ///< squared distance from the rim, infinity outside the ring
    const float* mobility;  ///< or null
    float* weight;
    float limit;   ///< R^2
    float factor;  ///< 1 / sigma
    float end;     ///< exp(-R^2 / sigma) for the compact kernel, 0 for the printed one
    float slope;   ///< R^2 / sigma
};

struct WeightSums {
    std::uint32_t count = 0;  ///< of positive weight
    float largest = 0;
    double total = 0;
};

/// 8 x 8 samples between 3 x 3 nodes, four steps apart.
struct SpreadJob {
    float nodes[9];  ///< squared distances from the rim, negative beyond it
    const std::uint8_t* marks;
    float* square;  ///< out: infinity where marked
    std::uint32_t cols;
};

/// Samples off borders and seams; rows are a multiple of four long.
struct SmoothJob {
    Rect rect;
    std::uint32_t cols;
    ConstPlanes now, before;
    const float* mobility;  ///< or null
    std::uint8_t* marks;    ///< bit 2: how far it moved counts, others have not moved
    float *x, *y;           ///< out, where bit 2 is set: half its own way and half the mean of its four neighbours'
    std::uint32_t* z;       ///< the bits of the third coordinate
};

struct BulgeJob {
    Rect rect;
    std::uint32_t cols;
    ConstPlanes from, normal;
    Planes to;
    const float* weight;
    float beta;
    bool clamp;  ///< to the plane
    float n[3], d;
};

struct HoldJob {
    ConstPlanes normal;
    const float* weight;
    float beta;
    float n[3], d;
};

struct ContactRows {
    /// Six times the signed volume over `origin` of the quads' triangles.
    double (*volume)(const QuadJob& job) noexcept;
    /// Six times the volume the quads' triangles swept on the way from `from` to where they are.
    /// Samples whose marks and weight are 0 have not moved.
    double (*swept)(const QuadJob& job, ConstPlanes from, const std::uint8_t* marks, const float* weight) noexcept;
    /// Adds to c[0..2] six times the coefficients of beta, beta^2, beta^3 of the volume along weight * normal.
    void (*cubic)(const QuadJob& job, ConstPlanes normal, const float* weight, double* c) noexcept;
    /// Area of quads whose first corner is marked, by the cross product of their diagonals.
    double (*area)(const QuadJob& job, const std::uint8_t* marks) noexcept;
    void (*mark)(const MarkJob& job, MarkSums& sums) noexcept;
    /// saved = now, and now = saved where bit 0 of the marks is set.
    void (*exchange)(const std::uint8_t* marks, Planes now, Planes saved, const Rect& rect,
                     std::uint32_t cols) noexcept;
    /// Samples of positive weight that are inside a round obstacle go to the nearest point of its border.
    void (*put_back)(const MarkJob& job, const float* weight, Planes at) noexcept;
    /// Marks with bit 3 the samples that move, have moved, or are marked with bit 0.
    void (*smooth)(const SmoothJob& job) noexcept;
    WeightSums (*weights)(const WeightJob& job) noexcept;
    void (*spread)(const SpreadJob& job) noexcept;
    /// Six times the volume it costs to keep samples that beta weight normal would take beyond a plane out of it.
    double (*held_back)(const QuadJob& job, const HoldJob& hold) noexcept;
    /// to = from + beta weight normal where weight > 0.
    void (*bulge)(const BulgeJob& job) noexcept;
};

extern const ContactRows kPlainContactRows;
/// Those that go with the state's own loops.
[[nodiscard]] const ContactRows& choose_contact_rows(const RowKernels* rows) noexcept;

}  // namespace dgm::detail
