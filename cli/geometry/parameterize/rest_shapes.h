// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/rest_shapes.h
// Faces laid flat: the constant matrices that linear finite elements on a surface need.
#pragma once
#include <array>
#include <vector>

#include "geometry/parameterize/parameterizer.h"

namespace dgm::bake {

struct RestShape {
    std::array<Vec2d, 3> hat;  ///< gradients of the hat functions of the corners: J = sum over corners of x_k hat_k^T
    double area = 0;
};

/// First edge along x, third corner above it. Slivers are made at least 1e-6 as high as long, so that every Jacobian is
/// finite.
/// @throws model::Error kMapInvalid if a face has no extent at all or is not finite
[[nodiscard]] std::vector<RestShape> rest_shapes(const DiskView& disk);

}  // namespace dgm::bake
