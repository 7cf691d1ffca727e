// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/free_maps.h
// Maps of a disk whose border is free: least squares conformal and as rigid as possible.
#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "geometry/parameterize/parameterizer.h"

namespace dgm::bake {

/// Weight of a face in the conformal energy.
enum class LscmWeight {
    kArea,         ///< its area, as the paper has it: the same answer whatever the triangulation, in the limit
    kSquaredArea,  ///< its squared area: CGAL 5.5 and programs like it solve this, since they leave out a normalisation
};

/// Least squares conformal map [Levy, Petitjean, Ray, Maillot 2002]: least sum over faces of
/// weight * ((u_x - v_y)^2 + (u_y + v_x)^2), with two vertices pinned: those at the two ends of the longest axis of the
/// bounding box, at (0, .) and (1, .) where . is their place along the second longest (CGAL's choice).
/// @return one point per vertex; may have flips and overlap itself
/// @throws model::Error kMapInvalid if the system cannot be solved, kInterrupted
/// Cost: one sparse Cholesky factorization of 2V unknowns. Deterministic.
[[nodiscard]] std::vector<Vec2d> lscm_map(const DiskView& disk, LscmWeight weight, const model::Progress& progress);

struct ArapOptions {
    std::size_t iterations = 100;
    double tolerance = 1e-6;  ///< stop when an iteration lowers the energy by less than this share of it
};

struct ArapReport {
    double energy = 0;           ///< arap_energy() of the map
    std::size_t iterations = 0;  ///< local and global steps
};

/// As-rigid-as-possible map [Liu, Zhang, Xu, Gotsman, Gortler 2008]: local steps fit a rotation to each face, global
/// steps solve one and the same Laplacian for u and v. Between them the iterates are extrapolated by Anderson's method,
/// a step that does not lower the energy being taken back [Peng, Deng, Zhang, Geng, Qin, Liu 2018].
/// @param start  one point per vertex, as large as the surface; flips allowed
/// @return one point per vertex; its energy is not above that of one plain step from `start`; may have flips
/// @throws model::Error kMapInvalid if a face has no extent or the system cannot be solved, kInterrupted
/// Cost: one factorization of V unknowns, then a solve and two passes over the faces an iteration. Deterministic.
[[nodiscard]] std::vector<Vec2d> arap_map(const DiskView& disk, std::vector<Vec2d> start, const ArapOptions& options,
                                          const model::Progress& progress, ArapReport* report = nullptr);

/// Sum over faces of share of the area * |J - R|^2 with R the rotation nearest to the map's Jacobian J; in singular
/// values (s1 - 1)^2 + (s2 - 1)^2, the smaller one negative where a face is flipped. Slivers count as at least 1e-6 as
/// high as long.
[[nodiscard]] double arap_energy(const DiskView& disk, std::span<const Vec2d> uv);

/// A map to start arap_map() from: border on a circle by arc length, inside harmonic with weights clamped to positive
/// ones; then as large as the surface.
/// @throws as lscm_map()
[[nodiscard]] std::vector<Vec2d> harmonic_disk_map(const DiskView& disk, const model::Progress& progress);

}  // namespace dgm::bake
