// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/curved_rest_shapes.h
// Rest shapes that give curved places more room in the map.
#pragma once
#include <vector>

#include "geometry/parameterize/rest_shapes.h"

namespace dgm::bake {

/// The faces laid flat at the scale of the unit square, and weighted by 1 + |II|^2 over the square of its mean |II|: a
/// step h misses a surface by h^2 |II|, so that the levelling evens out errors where plain areas even out steps. After
/// the fit that is worth 0.9 to 1 dB on heads and organs at 257 a side. The curvature is that of smoothed normals,
/// smoothed again; a weight of more than 100 would be a sharp edge's, which no step resolves.
[[nodiscard]] std::vector<RestShape> curved_rest_shapes(const DiskView& disk);

/// The faces laid flat in the metric |II|, at the scale of the unit square, and weighted by their areas: of the energy
/// with the fourth power of the stretch this makes the squared error itself, so that cells become long where the
/// surface bends one way only. |II| is that of smoothed normals, and its square is smoothed as a tensor; a curvature
/// counts as at least half the mean, and as at least a quarter of the other one: below that the grid's own quads, and
/// noise, decide the error.
[[nodiscard]] std::vector<RestShape> directed_rest_shapes(const DiskView& disk);

}  // namespace dgm::bake
