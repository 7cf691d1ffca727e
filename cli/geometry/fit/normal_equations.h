// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/normal_equations.h
// The damped least-squares step of a point-to-surface fit, over the classes of a chart.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/fit/welded_grid.h"

namespace dgm::bake {

/// Sums rows "the surface point at b on this face should move by n . gap along n" into 3x3 blocks per class and per
/// edge: a step of conjugate gradients then costs one pass over the edges, however many points there are. Sums run in
/// the order of the calls: the same bits every time.
class NormalEquations {
 public:
    explicit NormalEquations(const WeldedGrid& grid);

    void add(std::uint32_t face, const std::array<double, 3>& b, const Vec3d& gap, const Vec3d& normal, double weight);

    /// Minimises the rows + damping * (own diagonal) * |step|^2 by conjugate gradients with 3x3 block Jacobi
    /// preconditioning; classes marked `fixed` stay 0.
    [[nodiscard]] std::vector<Vec3d> solve(std::span<const char> fixed, double damping, int iterations);

 private:
    using Block = std::array<double, 6>;  // symmetric: xx, xy, xz, yy, yz, zz

    const WeldedGrid& grid_;
    std::vector<Block> diagonal_, off_;
    std::vector<Vec3d> right_;
};

}  // namespace dgm::bake
