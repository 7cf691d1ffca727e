// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/damped_reweight.h
// Stretch lowered by reweighting a convex map, with steps that shorten where they overshoot.
#pragma once
#include <vector>

#include "geometry/parameterize/convex_map.h"

namespace dgm::bake {

/// [Yoshizawa 2004] with steps that shorten: weights are divided by (stretch_i * stretch_j)^e, e = 1 at first; a step
/// that raises the energy is taken back and e halved. At most `solves` solves after the first. Returns the iterate with
/// the least stretch.
/// @throws model::Error kMapInvalid, kInterrupted
[[nodiscard]] std::vector<Vec2d> damped_stretch_map(const DiskView& disk, int solves, const model::Progress& progress);

}  // namespace dgm::bake
