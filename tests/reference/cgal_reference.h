// SPDX-License-Identifier: GPL-3.0-or-later
// tests/reference/cgal_reference.h
// CGAL's free-border parameterizers exactly as CGAL ships them: what ours are tested and timed against.
#pragma once
#include <optional>
#include <vector>

#include "geometry/parameterize/parameterizer.h"

namespace dgm::bake {

/// CGAL's ARAP_parameterizer_3 and LSCM_parameterizer_3 with their default solver, start, border and number of
/// iterations. Not part of any bake: no check of the input (CGAL may crash on what is no disk), no repair of flips.
/// @return nothing if CGAL reports an error; its map may hold NaN
[[nodiscard]] std::optional<std::vector<Vec2d>> cgal_default_arap(const DiskView& disk);
[[nodiscard]] std::optional<std::vector<Vec2d>> cgal_default_lscm(const DiskView& disk);

}  // namespace dgm::bake
