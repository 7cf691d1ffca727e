// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/spherical_map.h
// A closed surface of genus 0 on the unit sphere.
#pragma once
#include <vector>

#include "geometry/mesh/half_edges.h"
#include "model/progress.h"

namespace dgm::bake {

struct SphericalOptions {
    int sweeps = 12;  ///< of vertex relaxation on every level
};

/// Coarse-to-fine with little stretch [Praun, Hoppe 2003]: simplifies to a tetrahedron, puts that on the sphere and
/// the vertices back, each inside the kernel of its ring on the sphere, and relaxes them one at a time on the stretch
/// of their ring (squared, as multilevel_map.h). No step turns a spherical triangle over.
///
/// @param mesh  closed, oriented, connected, genus 0
/// @return  one unit vector per vertex; seen from outside every face is counter-clockwise, with a margin above rounding
/// @throws model::Error kMethodUnsuited if the mesh is not closed or not of genus 0, kMapInvalid if it cannot be
///     simplified to a tetrahedron or crowds beyond double precision, kInterrupted
/// Deterministic, single-threaded, linear in the number of faces.
[[nodiscard]] std::vector<Vec3d> spherical_map(const TriMesh& mesh, const SphericalOptions& options,
                                               const model::Progress& progress);

/// True if det(a, b, c) > 0 for certain: the triangle is counter-clockwise seen from outside the sphere. A filter, not
/// an exact sign: triangles too thin for it are refused.
[[nodiscard]] bool surely_outward(const Vec3d& a, const Vec3d& b, const Vec3d& c);

}  // namespace dgm::bake
