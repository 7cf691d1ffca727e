// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/stretch_map.h
// Disk to square with little L2 stretch, for shapes easy and hard.
#pragma once
#include <cstddef>
#include <vector>

#include "geometry/parameterize/parameterizer.h"

namespace dgm::bake {

/// Reweighted convex map [Yoshizawa 2004] (convex_map.h), then the exact descent (slim.h).
///
/// Where the convex map crowds (parts of the surface behind necks, on ribbons along one side of the square), a spread
/// start takes its place if it stretches less, and the descent first runs on a small power of the stretch: there every
/// crowded face grows at once, not the worst alone.
///
/// @param newton_steps  at most so many steps of the descent for an ordinary map (most of the gain comes in the first);
///     a crowded one gets as many as it needs. 0 asks for a trial: a few steps,
///     to judge a cut by.
/// @return one point per vertex, border as in disk.border_uv to the bit; flips are for the caller to count
/// @throws model::Error kMapInvalid if no start could be solved, kInterrupted
[[nodiscard]] std::vector<Vec2d> stretch_map(const DiskView& disk, std::size_t newton_steps,
                                             const model::Progress& progress);

/// Goes on with a map that has crowded limbs into points: gives them room (limb_growth.h) and descends, by turns, until
/// the stretch is `enough` or falls no more; 600 steps at most, fewer where there are more than some 7,000 faces.
///
/// @param uv  flip-free; its border stays
/// @return  flip-free, with no more L2 stretch than `uv`
/// @throws model::Error kInterrupted
[[nodiscard]] std::vector<Vec2d> uncrowd(const DiskView& disk, std::vector<Vec2d> uv, double enough,
                                         const model::Progress& progress);

}  // namespace dgm::bake
