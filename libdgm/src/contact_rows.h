// SPDX-License-Identifier: MIT
// libdgm/src/contact_rows.h
// Inner loops of a contact, built once per instruction set as rows.h is. Arithmetic is in double, four lanes.
//
// Projecting and bulging round alike in all variants and lanes, so copies of a class agree; sums differ in their order.
#pragma once
#include <cstdint>

#include "rows.h"

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

struct PlaneJob {
    Rect rect;
    std::uint32_t cols;
    Planes at;
    double n[3], d;  ///< n . p - d is the distance
    double tolerance;
    std::uint8_t* marks;  ///< 1 where beyond
};

struct PlaneSums {
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

struct ContactRows {
    /// Six times the signed volume over `origin` of the quads' triangles.
    double (*volume)(const QuadJob& job) noexcept;
    /// Adds to c[0..2] six times the coefficients of beta, beta^2, beta^3 of the volume along weight * normal.
    void (*cubic)(const QuadJob& job, ConstPlanes normal, const float* weight, double* c) noexcept;
    /// Area of quads whose first corner is marked, by the cross product of their diagonals.
    double (*area)(const QuadJob& job, const std::uint8_t* marks) noexcept;
    void (*mark)(const PlaneJob& job, PlaneSums& sums) noexcept;
    void (*project)(const PlaneJob& job, const float* mobility) noexcept;
    /// @return samples of positive weight.
    std::uint32_t (*weights)(const WeightJob& job) noexcept;
    /// to = from + beta weight normal where weight > 0.
    void (*bulge)(const BulgeJob& job) noexcept;
};

extern const ContactRows kPlainContactRows;
/// Those that go with the state's own loops.
[[nodiscard]] const ContactRows& choose_contact_rows(const RowKernels* rows) noexcept;

}  // namespace dgm::detail
