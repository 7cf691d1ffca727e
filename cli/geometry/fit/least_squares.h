// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/least_squares.h
// One damped least-squares step of a point-to-surface fit.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "model/vec.h"

namespace dgm::bake {

/// The surface point sum_k b[k] X[unknown[k]] should move by `gap`, weighed by  weight (share I + (1 - share) n n^T).
struct FitRow {
    std::array<std::uint32_t, 3> unknown;
    std::array<double, 3> b;
    model::Vec3d gap, normal;
    double weight;
};

/// Minimises  sum of the rows + damping * (own diagonal) * |step|^2  by conjugate gradients with 3x3 block Jacobi
/// preconditioning, matrix-free; unknowns marked `fixed` stay 0. Sums run in row order: the same bits every time.
[[nodiscard]] std::vector<model::Vec3d> least_squares_step(std::span<const FitRow> rows, std::size_t unknowns,
                                                           std::span<const char> fixed, double share, double damping,
                                                           int iterations);

}  // namespace dgm::bake
