// SPDX-License-Identifier: MIT
// libdgm/src/cloth/kernels.h
// The loops of a cloth step over rows of samples, built once per instruction set and chosen at creation.
//
// Planes have `pitch` floats a row, a whole number of blocks of kBlock and at least one more than there are columns,
// with
// a row of zeros before the first and after the last one. What lies past a row's end stays 0. Every value comes from
// single correctly rounded operations in the same order whatever the number of lanes, so all variants give the same
// bits.
#pragma once
#include <cstddef>
#include <cstdint>

namespace dgm::detail::cloth {

inline constexpr std::size_t kBlock = 16;

/// Three planes, one a coordinate.
struct Field {
    float* p[3] = {};
};

/// Symmetric 3 x 3 blocks: xx, yy, zz, xy, xz, yz.
struct Blocks {
    float* p[6] = {};
};

/// Stiffness of the cloth for one unit of area of rest: N/m.
struct Moduli {
    float warp, weft, cross, shear;
    float warp_uneven, weft_uneven;  ///< against strain that changes across a quad, by the square of its change
};

/// A weighted sum of rows or columns.
struct Taps {
    static constexpr std::uint32_t kMost = 8;
    std::uint32_t count = 0, at[kMost] = {};
    float weight[kMost] = {};
    void add(std::uint32_t index, float by) noexcept {
        at[count] = index;
        weight[count++] = by;
    }
};

/// Shape of one level, and what it resists. Quad (i, j) has the samples (i, j), (i + 1, j), (i, j + 1) and
/// (i + 1, j + 1) as corners; u leads along columns from row to row, v along rows. Planes start at sample (0, 0).
struct Sheet {
    std::uint32_t rows = 0, cols = 0;
    std::ptrdiff_t pitch = 0;
    Moduli moduli{};
    Field u, v;    ///< edges of the present shape: x(i + 1, j) - x(i, j) and x(i, j + 1) - x(i, j), metres
    Field f1, f2;  ///< quads: deformation gradient, along u and across
    /// Quads: the inverse of the mean rest edges in the rest plane, [q11 q12; 0 q22], the area times the painted
    /// stiffness (0: no quad), how much of it resists uneven strain, 0 .. 1, and the parts of the rest quad's twist
    /// along its mean edges.
    float *q11 = nullptr, *q12 = nullptr, *q22 = nullptr, *area = nullptr, *uneven = nullptr;
    float *twist_u = nullptr, *twist_v = nullptr;
    float *s1 = nullptr, *s2 = nullptr;              ///< quads: tension that stiffens them across, N/m
    float *square1 = nullptr, *square2 = nullptr;    ///< quads: squared stretch, of the finest ones on the mean
    float *tension1 = nullptr, *tension2 = nullptr;  ///< coarse quads: s1 and s2 of the finest ones on the mean
    float* saddle = nullptr;  ///< quads: the rest of the rest quad's twist, along its normal, metres; null: flat
    /// Samples: a stencil along u and one along v, whose values are the curvature of that line of the grid times the
    /// normal, times the root of bending stiffness and area. Along u:
    /// u_up (x(i + 1, j) - x) + u_down (x(i - 1, j) - x) + u_side (x(i, j + 1) - x(i, j - 1)).
    float *u_up = nullptr, *u_down = nullptr, *u_side = nullptr;
    float *v_up = nullptr, *v_down = nullptr, *v_side = nullptr;
    float *u_curved = nullptr, *v_curved = nullptr;  ///< samples: their values at rest along the normal; null: flat
    float plate = 0;                                 ///< bending stiffness, N m: quads against twist
    float* mass = nullptr;                           ///< kg
    Field normal;                                    ///< of contacts
    float *press = nullptr, *drag = nullptr;         ///< stiffness of contacts along and across their normals, N/m
    std::uint8_t* touched = nullptr;                 ///< rows: some sample has a contact
    float* scratch = nullptr;                        ///< kScratchRows rows, kMostProducts times
};
inline constexpr std::size_t kScratchRows = 39;
inline constexpr std::uint32_t kMostProducts = 4;  ///< at once; each has a scratch of its own

/// gradient = slope of membrane and bending + by_dt2 mass inertial; f1, f2, s1, s2, square1, square2 of the sheet;
/// energy of membrane and bending; inertia = sum of mass |inertial|^2. With `ahead` energy and inertia of the shape
/// `by` times this way further, and nothing else is written.
struct ForceJob {
    Sheet on;
    const double* at[3];
    Field gradient, inertial, ahead;
    float by_dt2;
    double by;
    double* inertia;
};

/// product = (mass by_dt2 + contacts + membrane + bending) from. Samples' own parts: copies of a class add up.
enum class Product : std::uint8_t {
    Whole,     ///< to = product
    Residual,  ///< to = free (own right - product)
    Polish,    ///< from = sum: residual = free (right - product), way = step inverse residual, sum += way
    Smooth,    ///< from = way: residual -= product, way = keep way + step inverse residual, sum += way
    Curve,     ///< dots = from . product, from . right, right . product, product . product
};
struct ProductJob {
    Sheet on;
    Product kind;
    float by_dt2;
    Field from, to, right, residual, sum;
    Field way;  ///< Polish, Smooth: null if neither it nor the residual is needed any more
    Blocks inverse;
    float keep, step;
    const float *own, *free;
    double* dots;
};

/// at = start = at + free (h v + fall h^2 g), was = at before, inertial = free (fall - 1) h^2 g.
/// @return sum of mass |free (h v + h^2 g)|^2
struct StartJob {
    std::size_t count;
    double* at[3];
    double* was[3];
    Field velocity, inertial;
    const float *fall, *free, *mass;
    double h, gravity[3];
};
/// v = slow (at - was) / h; fall = its change along gravity, over gravity, in 0 .. 1.
struct FinishJob {
    std::size_t count;
    const double* at[3];
    const double* was[3];
    Field velocity;
    float* fall;
    const float* mass;
    double by_h, slow, direction[3];  ///< gravity / (h |gravity|^2)
    double kinetic, moment[3];        ///< answers: of mass v^2, mass at
};
/// to = by at, without the ends of rows.
struct ShapeJob {
    std::uint32_t rows, cols;
    std::ptrdiff_t pitch;
    const double* at[3];
    float* to[3];
    double by;
};
/// at += by way.
struct MoveJob {
    std::size_t count;
    double* at[3];
    Field way;
    double by;
};

/// Blocks become their inverses times `free`; with a gradient right = - free gradient, sum = step inverse right.
/// @return with a gradient the sum of own right . right
struct InvertJob {
    std::size_t count;
    Blocks of;
    const float *free, *own;
    Field gradient, right, sum;
    float step;
};
/// Diagonal blocks of the same matrix, samples' own parts, which are then inverted `at_once` or later.
struct DiagonalJob {
    Sheet on;
    float by_dt2;
    bool at_once;
    InvertJob invert;
};

/// residual -= product; way = keep way + step inverse residual; sum += way. Begin: residual = right, way = step inverse
/// residual, sum = way, and no product; Go on: the same from a residual, but sum += way.
enum class Sweep : std::uint8_t { Begin, GoOn, Next };
struct SweepJob {
    std::size_t count;
    Field right, product, residual, way, sum;
    Blocks inverse;
    float keep, step;
    Sweep kind;
    bool keeps;  ///< residual and way are needed further on
};

/// to = a x + b y, times free.
struct AddJob {
    std::size_t count;
    float a, b;
    Field x, y, to;
    const float* free;
};

/// Interpolation from a level to the next finer one, and its transpose. The first `even` columns of the coarse one are
/// at twice their index.
struct TransferJob {
    const Sheet *fine, *coarse;
    std::uint32_t even;
    const Taps *rows, *columns;  ///< by row and column of what is written
    Field from, to;
    const float* free;  ///< of what is written; restrict: may be null
    int planes;
};
/// Edges, tension1, tension2, square1, square2 of a coarse level from those of the finer one, or edges from where its
/// samples are.
struct ThinJob {
    const Sheet *fine, *coarse;
    const double* at[3];
    std::uint32_t even;
    const std::uint32_t *rows, *columns;  ///< on the finer level
    const float *tension1, *tension2;     ///< of the finer one
};

struct Kernels {
    const char* name;
    double (*force)(const ForceJob&) noexcept;
    void (*products)(const ProductJob*, std::uint32_t count) noexcept;
    double (*diagonal)(const DiagonalJob&) noexcept;
    double (*invert)(const InvertJob&) noexcept;
    void (*sweep)(const SweepJob&) noexcept;
    void (*add)(const AddJob&) noexcept;
    double (*start)(const StartJob&) noexcept;
    void (*finish)(FinishJob&) noexcept;
    void (*move)(const MoveJob&) noexcept;
    void (*shape)(const ShapeJob&) noexcept;
    void (*restrict_to)(const TransferJob&) noexcept;
    void (*interpolate_to)(const TransferJob&) noexcept;  ///< adds
    void (*thin)(const ThinJob&) noexcept;
    /// s1, s2 of a coarse level. Where the fine quads of a coarse one stretch in many directions, their mean stretch is
    /// less than theirs; what is lost resists in all directions, which is no less than what they do.
    void (*stiffen)(const Sheet&) noexcept;
    /// Sum of own a . b over samples.
    double (*inner)(std::size_t count, const float* own, const Field& a, const Field& b) noexcept;
};
[[nodiscard]] const Kernels& choose_kernels(bool plain) noexcept;

}  // namespace dgm::detail::cloth
