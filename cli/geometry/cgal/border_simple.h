// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cgal/border_simple.h
// Does a closed polygon cross or touch itself?
#pragma once
#include <span>

#include "model/vec.h"

namespace dgm::bake {

/// True if the closed polygon through `border` is simple: its edges share nothing but their common corners. A map of a
/// disk without flips whose border is simple is injective, so this is the overlap test of free-border charts.
/// Exact predicates, sweep line, O(n log n). False for fewer than three points and for NaN or infinite ones.
[[nodiscard]] bool border_is_simple(std::span<const model::Vec2d> border);

}  // namespace dgm::bake
