// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/flip_repair.h
// Repairs a few flipped faces of a map without touching the rest of it.
#pragma once
#include <optional>
#include <vector>

#include "geometry/parameterize/parameterizer.h"

namespace dgm::bake {

/// Shape towards which the surroundings of a flip are drawn.
enum class RepairShape {
    kConformal,  ///< any scale, angles kept: for conformal maps
    kIsometric,  ///< the size of the surface, too
};

/// Untangles the rings around each group of flipped faces by the regularised energy of [Garanzha et al. 2021], all
/// vertices that also belong to faces outside being held; more rings where few are not enough. Border vertices of the
/// disk move freely.
/// @return a map without flips that differs from `uv` around its flips alone; nothing if more than a tenth of the faces
///         would have to move (two fifths for kIsometric, whose collapsed places need room to spread), or if untangling
///         does not succeed
/// @throws model::Error kInterrupted
/// Deterministic.
[[nodiscard]] std::optional<std::vector<Vec2d>> repair_flips(const DiskView& disk, std::vector<Vec2d> uv,
                                                             RepairShape shape, const model::Progress& progress);

}  // namespace dgm::bake
