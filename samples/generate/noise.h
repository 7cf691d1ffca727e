// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/noise.h
// Repeatable noise from integer hashes: the same on every machine, unlike the distributions of <random>.
#pragma once
#include <cstdint>

#include "model/vec.h"

namespace dgm::samples {

/// Uniform in [0, 1), a pure function of its arguments.
double hash01(std::int64_t x, std::int64_t y, std::int64_t z, std::uint32_t seed);

/// Value noise in [-1, 1] on the unit lattice, twice continuously differentiable.
double noise3(const model::Vec3d& p, std::uint32_t seed);

/// Sum of `octaves` of noise3, each half as strong and twice as fine; stays within [-1, 1].
double fractal3(const model::Vec3d& p, int octaves, std::uint32_t seed);

/// Value noise in [-1, 1] that repeats after period_x, period_y lattice cells, both > 0.
double tiled_noise2(double x, double y, int period_x, int period_y, std::uint32_t seed);

/// Distances to the nearest and second nearest feature point, one jittered point per unit cell [Worley 1996].
struct Cells {
    double nearest, second;
    double id;  ///< 0..1, constant within a cell
};
Cells cells3(const model::Vec3d& p, std::uint32_t seed);

/// 0 below `low`, 1 above `high`, smooth between.
double smooth_step(double low, double high, double x);

}  // namespace dgm::samples
