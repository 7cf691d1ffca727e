// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/hard_meshes.h
// Families of meshes that get harder by one number. All are oriented, manifold and connected.
#pragma once
#include <cstdint>

#include "model/tri_mesh.h"

namespace dgm::bench {

/// A dome over a square of side 1, 17 x 17 vertices.
[[nodiscard]] model::TriMesh dome();

/// The dome with one strip of quads `thinness` (0..1] of its width.
[[nodiscard]] model::TriMesh sliver_dome(double thinness);

/// The dome `diagonals` of its own diagonals away from the origin, towards (1, 1, 1).
[[nodiscard]] model::TriMesh offset_dome(double diagonals);

/// The dome `scale` times as large.
[[nodiscard]] model::TriMesh scaled_dome(double scale);

/// The dome with cells that shrink geometrically in both directions, the last `ratio` >= 1 times narrower than the
/// first.
[[nodiscard]] model::TriMesh graded_dome(double ratio);

/// A cone whose tip has `valence` >= 3 neighbours, in rings of so many vertices.
[[nodiscard]] model::TriMesh fan_cone(std::uint32_t valence);

/// An open tube of circumference 1 and length `aspect`.
[[nodiscard]] model::TriMesh tube(double aspect);

/// A slab of cubes with `holes` square holes through it: closed, genus `holes`.
[[nodiscard]] model::TriMesh pierced_slab(std::uint32_t holes);

/// A closed bumpy ball of about `faces` faces, at least 80: an octahedron's faces split and pushed out.
[[nodiscard]] model::TriMesh bumpy_ball(std::uint64_t faces);

}  // namespace dgm::bench
