// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/limb_growth.h
// Gives limbs room in a map that crowds them into points.
#pragma once
#include <vector>

#include "geometry/parameterize/parameterizer.h"

namespace dgm::bake {

/// A convex map shrinks a limb by a factor from each ring of vertices to the next, and a descent whose one step must
/// not turn over any face takes hundreds of steps to undo what has become a factor of 1e10. Here all that lies beyond
/// a ring moves at once, by the similarity that lowers the L2 stretch most [Sander 2001]: what is inside keeps its
/// shape, so that only the faces at the ring decide. What lies beyond a ring is a connected part of the vertices that
/// are k edges or more from the border. These parts are nested, and a sweep takes them from the border inwards in
/// linear time.
///
/// @param disk  with a fixed border, flip-free by `uv`
/// @param sweeps  at most; ends where a sweep gains less than 1 %
/// @return  flip-free by the exact predicate, with no more stretch than `uv`; `uv` itself if nothing was gained
/// @throws model::Error kInterrupted
/// Deterministic, single-threaded.
[[nodiscard]] std::vector<Vec2d> grow_limbs(const DiskView& disk, std::vector<Vec2d> uv, int sweeps,
                                            const model::Progress& progress);

}  // namespace dgm::bake
