// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/implicit_surface.h
// Turns a function of space that is negative inside into a closed mesh of well-shaped triangles.
#pragma once
#include <functional>

#include "poly_mesh.h"

namespace dgm::samples {

using Field = std::function<double(const model::Vec3d&)>;

/// Box and spacing of the sampling lattice; the surface must lie inside the box.
struct Lattice {
    model::Vec3d low, high;
    double cell = 1;
};

/// Surface nets [Gibson 1998] on the lattice, then rounds of smoothing and projection back onto field = 0, then quads
/// split by their shorter diagonal. Triangles face outward; no UVs.
PolyMesh mesh_zero_set(const Field& field, const Lattice& lattice);

/// Unit gradient of the field by central differences.
model::Vec3d field_normal(const Field& field, const model::Vec3d& p);

/// min(a, b) with a blend of width k > 0 where they are close; never above min(a, b).
double smooth_min(double a, double b, double k);
inline double smooth_max(double a, double b, double k) {
    return -smooth_min(-a, -b, k);
}

}  // namespace dgm::samples
