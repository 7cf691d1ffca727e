// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/edge_snap.h
// Puts samples on the edges of the source that the grid's faces lie across.
#pragma once
#include "geometry/fit/fit_state.h"

namespace dgm::bake {

/// Where facets of the source are larger than the grid's faces, the error sits where a face lies across an edge between
/// them: least squares see a slope there that goes down to both sides, and stop half-way. So samples beside such edges
/// try the nearest points of them and their ends, each with the diagonals of the quads around it that go with it best.
/// The places that lower the squared distances the most are taken first, and none that would fold, tilt or flatten a
/// face. Rounds of the fit leave samples on an edge, since the planes of both sides hold them there. Samples on the
/// source's border stay. Parallel, with the same bits for any number of threads; bounded work.
/// @return  true if a sample moved; the matches are up to date then, but for those of the edges
bool snap_to_edges(FitState& fit);

}  // namespace dgm::bake
