// SPDX-License-Identifier: MIT
// libdgm/include/dgm/force.h
// Computes the force at the tool, paper eqs. 8-10.
#pragma once
#include <dgm/export.h>
#include <dgm/result.h>
#include <dgm/vec.h>

namespace dgm {

/// Computes f = -(d / |d_max|)^3 * f_max, axis by axis; d is clamped to +-d_max first, so |f| <= f_max on each axis.
///
/// @param d      displacement at the contact, local units
/// @param d_max  largest displacement, > 0
/// @param f_max  largest force, >= 0, in any unit, which is that of the answer
/// @return BadArgument if anything is not finite or out of range. Thread-safe, no state.
[[nodiscard]] DGM_API Result<Vec3> contact_force(Vec3 d, float d_max, float f_max) noexcept;

}  // namespace dgm
