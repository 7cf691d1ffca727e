// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/patch_repair.h
// Repairs inverted faces a patch of samples at a time, by the least of a barrier energy.
#pragma once
#include <cstddef>
#include <span>

#include "geometry/fit/matches.h"

namespace dgm::bake {

/// What a patch that lies flat may cost.
struct PatchAllowance {
    double largest = 1.3;  ///< distance of a point, over the farthest of all
    double squares = 0.1;  ///< what all patches together add to the squared distances, of their sum
};
/// No bound: for callers that fit the grid again around the patches, and measure then what they have cost.
inline constexpr PatchAllowance kAnyPatch{1e6, 1e6};

/// Where a patch of the grid overlaps itself on a smooth part of the source, a face between the two layers is inverted,
/// and no place for one or two samples turns it back: the patch has to give way as a whole. The samples some rings
/// around each inverted face slide along the source together, to the least of an energy that has a barrier where a face
/// turns [Garanzha, Kaporin, Kudryavtseva, Protais, Ray, Sokolov 2021, Foldover-free maps in 50 lines of code] and
/// keeps each face near its present shape, with its right side up. A patch stays as it was unless fewer of its faces
/// are inverted then by the measure (metrics/turned_faces.h), and the error stays within the allowance. Classes marked
/// `fixed` stay. `matches` is kept up to date but for the points. Bounded work; deterministic.
/// @param index    of the source
/// @param upward   per face of the source: its normal at the scale of the grid
/// @param effort   how often a sample may be moved; less by the share spent
/// @return  true if a sample moved
bool repair_by_patch(const LinkedSurface& source, const ClosestPointIndex& index, std::span<const Vec3d> upward,
                     WeldedGrid& grid, Matches& matches, std::span<const char> fixed,
                     std::span<const std::uint32_t> inverted, std::size_t& effort,
                     const PatchAllowance& allowance = {});

}  // namespace dgm::bake
