// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/free_methods.h
// The parameterization methods whose border is free.
#pragma once
#include <memory>
#include <string_view>

#include "geometry/parameterize/parameterizer.h"

namespace dgm::bake {

/// | name   | method |
/// |--------|--------|
/// | `lscm` | least squares conformal map [Levy et al. 2002] |
/// | `arap` | as-rigid-as-possible, local/global [Liu et al. 2008] |
/// | `slim` | least symmetric Dirichlet energy, flip-free throughout [Smith, Schaefer 2015], [Rabinovich et al. 2017] |
///
/// The centroid of a map is at the origin and, but for `arap` and `slim`, whose size is part of their answer, it has
/// the surface's area. A map of `lscm` or `arap` with flips is repaired: few flips where they are (repair_flips()),
/// else it is replaced by a flip-free descent (slim.h): of the ARAP energy with a barrier, or, for `lscm`, of the
/// symmetric Dirichlet energy: a conformal map that flips in doubles has scales that no grid can sample, and following
/// them was worse in angles, too (mean 4.3 against 1.5 on the camel head). If no flip-free start exists either, the map
/// with flips is returned. Overlaps are for the caller: border_simple.h.
///
/// solve() expects a disk (check_disk()) and throws model::Error kMapInvalid if it is none or if a solve fails,
/// kInterrupted, or kWorkerMemory out of memory. Deterministic, thread-safe.
/// @return nullptr for another name
[[nodiscard]] std::unique_ptr<Parameterizer> make_free_parameterizer(std::string_view method);

}  // namespace dgm::bake
