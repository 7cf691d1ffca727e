// SPDX-License-Identifier: MIT
// libdgm/src/physics/factor.h
// Block Cholesky factors of the second derivatives at rest, without contacts: the preconditioner of small grids.
//
// Unknowns of 4 x 4 samples are a tile of 48 rows. Tiles are eliminated by least degree. The diagonal is scaled to 1,
// so entries are small where the body hardly answers at one place to a push at the other: 16 x 16 such entries are
// dropped together, others kept in 16 bits. What is left is the factor of a positive definite matrix whatever was
// dropped.
#pragma once
#include <dgm/result.h>

#include "physics/level.h"

namespace dgm::detail {
struct PhysicsImpl;

namespace physics {

#ifdef DGM_NO_FACTORS  // pages: as small as can be
inline constexpr bool kFactors = false;
#else
inline constexpr bool kFactors = true;
#endif

/// H = L L^T by tiles.
struct Factor {
#ifndef DGM_NO_FACTORS
    std::uint32_t tiles = 0;
    Array<std::uint32_t> slot;        ///< by unknown: row of its x; y and z follow
    Array<std::uint32_t> start, row;  ///< squares of 16 x 16 below the diagonal tiles, by columns of squares
    Array<std::int16_t> value;        ///< of L, a square after the other, column-major
    Array<float> unit;                ///< by square: of its values
    Array<std::int16_t> own;          ///< by tile: inverse of L's on the diagonal, the squares of its lower triangle
    Array<float> own_unit;
    Array<float> scale, work;                      ///< by row; scale: 0 where there is no unknown
    double turn[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< of the body from rest, row-major
#endif
    float dt = 0;       ///< length of the steps that it is for
    int swell_age = 0;  ///< steps since PhysicsImpl::swell was solved for; 0: it is not there
};

inline constexpr std::uint32_t kMostFactored = 129 * 129;  ///< samples
/// Assembles and factorises for options.dt. @param bytes  that are taken already
/// @return OutOfMemory, LimitExceeded (options.max_bytes), BadArgument; `to` is as it was then.
[[nodiscard]] Result<void> make_factor(const PhysicsImpl& p, std::uint64_t bytes, Factor& to) noexcept;
/// Fits `turn` to the present shape at p.moved; as it was where there is none.
void fit_turn(PhysicsImpl& p) noexcept;
/// to = inverse times from, with the body turned; 0 at held unknowns. The map is linear, symmetric, positive definite.
void apply_inverse(PhysicsImpl& p, const Field& to, const Field& from) noexcept;

}  // namespace physics
}  // namespace dgm::detail
