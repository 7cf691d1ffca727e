// SPDX-License-Identifier: MIT
// libdgm/src/physics/kernels.h
// The loops of a physics step over all samples of a grid, built once per instruction set and chosen at creation.
//
// A loop runs over flat sample numbers, row ends included: where there is no triangle or no stencil its coefficients
// are 0. Planes therefore have kPad readable floats on both sides. Every value comes from single correctly rounded
// operations in the same order whatever the number of lanes, so all variants give the same bits.
#pragma once
#include <cstddef>
#include <cstdint>

namespace dgm::detail::physics {

/// Samples whose coefficients stand together: stencil[block][entry][lane]. A multiple of every number of lanes.
inline constexpr std::size_t kBlock = 16;
[[nodiscard]] constexpr std::size_t whole_blocks(std::size_t samples) noexcept {
    return (samples + kBlock - 1) / kBlock * kBlock;
}
[[nodiscard]] constexpr std::size_t blocked(std::size_t sample, std::size_t entry, std::size_t entries) noexcept {
    return sample / kBlock * entries * kBlock + entry * kBlock + sample % kBlock;
}

/// Three planes of floats, one a coordinate.
struct Field {
    float* p[3] = {};
};

inline constexpr std::size_t kNear = 9;  ///< entries (di, dj) of 3 x 3 stencils, row-major

/// residual -= (A + extra) way; next = keep way + step inverse residual; sum += next + carry way. `next` may be empty:
/// the residual alone.
struct SweepJob {
    std::size_t count;  ///< samples, whole blocks
    std::ptrdiff_t cols;
    const float* stencil;  ///< kNear entries
    const float *extra, *inverse;
    Field way, residual, next, sum;
    float keep, step, carry;
};

/// to = stencil(kNear) from; of its differences from the sample in the middle if the rows of the stencil sum up to 0:
/// then a field that is the same everywhere gives 0, whatever the rounding.
struct NearJob {
    std::size_t count;  ///< samples, whole blocks
    std::ptrdiff_t cols;
    const float* stencil;
    Field from, to;
    bool differences;
};

/// Rest shape of the triangles of a quad, blocked like a stencil: for both triangles the inverse of the rest edges in
/// the triangle's own plane (three numbers, [a b; 0 c]) and its weight (area; 0: no triangle).
inline constexpr std::size_t kQuadData = 8;
/// Quad s has the samples s, s + cols, s + cols + 1, s + 1 as corners.
struct Quads {
    std::size_t count;  ///< samples, whole blocks
    std::ptrdiff_t cols;
    const float* data;   ///< kQuadData entries
    const float* other;  ///< plane: 1 where the quad is split along diagonal 1
    Field rest, moved;   ///< metres; moved: displacement
};
struct QuadJob {
    Quads on;
    float shear, dilate;  ///< Lame's mu and lambda times thickness, N/m
    /// Gradient at the quad's corners (i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1), and twice the area vectors of its
    /// triangles.
    Field corner[4], area[2];
    float* energy;
    // Viscosity: stretches of the step before, three planes a triangle, and its modulus over dt; null: none.
    float* const* stretch = nullptr;
    float viscous = 0;
};
/// Writes the present stretches (S11, S12, S22 of both triangles).
struct StretchJob {
    Quads on;
    float* to[6];
};

/// corner += gradient of sum over triangles of (a + b + c) . area vector, by the values of a field at the corners.
struct TwistJob {
    Quads on;
    Field field;
    Field corner[4];
};

/// Bending of each sample: from twice the area vector and the stencil of the displacement to the moment and the field
/// whose gradient is that of the normal. Classes have been summed before.
struct BendJob {
    std::size_t count;
    const float *modulus, *height;  ///< B / area (0: no bending) and rest curvature times area
    Field rest_normal, area, curvature;
    Field moment, field;  ///< out; moment may be the same as curvature
    float* energy;        ///< 0 on copies
    const float* own;     ///< 1 at representatives, 0 at their copies
    float flat;           ///< weight of the part along the surface
};

/// Where samples are now, in double precision, and their inertia and foundation.
struct PlaceJob {
    std::size_t count;
    const double* at[3];
    Field delta, moved;
};
struct DiagonalJob {
    std::size_t count;
    const float *mass, *anchor, *free, *own;
    float by_dt2;
    Field delta, inertial, moved, target, gradient;
};
/// Volume of rest + at + delta + step way; `way` may be empty.
struct VolumeJob {
    std::size_t count;
    std::ptrdiff_t cols;
    const float *other, *quad;  ///< quad: 1 where sample s has one
    const double* at[3];
    Field rest, delta, way;
    double step;
};

inline constexpr std::size_t kTileUnknowns = 16, kTileRows = 3 * kTileUnknowns, kSquare = 16;
inline constexpr std::size_t kOwnSquares = 6;  ///< of a diagonal tile: the lower triangle
/// Solves with block factors, see factor.h.
struct FactorJob {
    std::size_t tiles;
    const std::uint32_t *start, *row;
    const std::int16_t* value;
    const float* unit;
    const std::int16_t* own;  ///< inverses of diagonal tiles
    const float* own_unit;
    float* x;  ///< right side, then solution
};

struct Kernels {
    const char* name;
    void (*sweep)(const SweepJob&) noexcept;
    void (*near)(const NearJob&) noexcept;
    void (*quads)(const QuadJob&) noexcept;
    void (*stretches)(const StretchJob&) noexcept;
    void (*twist)(const TwistJob&) noexcept;
    void (*bend)(const BendJob&) noexcept;
    /// Gathers what quads left at their corners; area vectors twice.
    void (*gather)(std::size_t count, std::ptrdiff_t cols, const Field* corner, const Field& to) noexcept;
    void (*gather_areas)(const Quads& on, const Field* area, const Field& to) noexcept;
    // The following work on `count` samples, whole blocks. Sums have eight parts by sample number.
    void (*add)(std::size_t count, const Field& to, float factor, const Field& from) noexcept;  ///< to += factor from
    /// to = factor weight from
    void (*weigh)(std::size_t count, const Field& to, float factor, const float* weight, const Field& from) noexcept;
    /// to = factor to - from
    void (*turn)(std::size_t count, const Field& to, float factor, const Field& from) noexcept;
    /// to = from + factor (to - from)
    void (*blend)(std::size_t count, const Field& to, float factor, const Field& from) noexcept;
    double (*inner)(std::size_t count, const float* own, const Field& a, const Field& b) noexcept;
    double (*total)(std::size_t count, const float* plane) noexcept;
    void (*place)(const PlaceJob& job) noexcept;
    /// gradient = free (gradient + forces). @return twice the inertial, then twice the foundation's energy
    void (*diagonal)(const DiagonalJob& job, double* energies) noexcept;
    double (*volume)(const VolumeJob& job) noexcept;
    void (*solve)(const FactorJob& job) noexcept;
    /// Of tiles: to -= a b^T; b may be given transposed.
    void (*subtract_product)(float* to, const float* a, const float* b) noexcept;
};
extern const Kernels kPlainKernels;
[[nodiscard]] const Kernels& choose_kernels(bool plain) noexcept;

}  // namespace dgm::detail::physics
