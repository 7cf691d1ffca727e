// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/stretch_map.cpp
#include "geometry/parameterize/stretch_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "geometry/mesh/half_edges.h"
#include "geometry/parameterize/convex_map.h"
#include "geometry/parameterize/limb_growth.h"
#include "geometry/parameterize/slim.h"

namespace dgm::bake {
namespace {

constexpr double kCrowded = 3;  // L2 stretch, 1 = isometric: bodies with well-cut limbs stay below 2.5

/// Infinite where a face is flipped.
double stretch_of(const DiskView& disk, const std::vector<Vec2d>& uv) {
    if (count_not_positive(disk.faces, uv) > 0) return std::numeric_limits<double>::infinity();
    return l2_stretch(disk.positions, disk.faces, uv);
}

std::vector<Vec2d> descend(const DiskView& disk, std::vector<Vec2d> uv, double power, std::size_t steps,
                           double tolerance, const model::Progress& progress) {
    SlimOptions options;
    options.energy = FlipFreeEnergy::kStretch;
    options.border_fixed = true;
    options.stretch_power = power;
    options.iterations = steps;
    options.tolerance = tolerance;
    options.patience = 3;  // one short step is no sign of the end
    return descend_flip_free(disk, std::move(uv), options, progress);
}

}  // namespace

std::vector<Vec2d> stretch_map(const DiskView& disk, std::size_t newton_steps, const model::Progress& progress) {
    std::vector<Vec2d> uv;
    double stretch = std::numeric_limits<double>::infinity();
    std::optional<model::Error> failure;
    try {
        uv = reweighted_stretch_map(disk, {}, progress);
        stretch = stretch_of(disk, uv);
    } catch (const model::Error& e) {
        if (e.code().number != model::codes::kMapInvalid.number) throw;
        failure = e;
    }
    const bool crowded = !(stretch < kCrowded);
    if (crowded) {
        std::optional<std::vector<Vec2d>> spread = flip_free_start(disk, progress, FlipFreeStart::kSpread);
        if (const double other = spread ? stretch_of(disk, *spread) : stretch; other < stretch) {
            uv = std::move(*spread);
            stretch = other;
        }
    }
    if (uv.empty() && failure) throw *failure;
    if (!std::isfinite(stretch)) return uv;

    constexpr double kSmallPower = 0.5;
    if (newton_steps == 0) {
        // A few steps for all: trials are compared with each other.
        if (!crowded) return descend(disk, std::move(uv), 2, 3, 3e-2, progress);
        uv = descend(disk, std::move(uv), kSmallPower, 15, 3e-2, progress);
        return descend(disk, std::move(uv), 2, 10, 3e-2, progress);
    }
    if (crowded) uv = descend(disk, std::move(uv), kSmallPower, 40, 1e-2, progress);
    return descend(disk, std::move(uv), 2, crowded ? std::max<std::size_t>(newton_steps, 100) : newton_steps, 1e-3,
                   progress);
}

std::vector<Vec2d> uncrowd(const DiskView& disk, std::vector<Vec2d> uv, double enough,
                           const model::Progress& progress) {
    constexpr double kFaceSteps = 4e6;
    constexpr std::size_t kSteps = 25, kMostRounds = 24;
    constexpr int kSweeps = 3;
    constexpr double kGain = 0.99;
    const double step = static_cast<double>(kSteps) * static_cast<double>(disk.faces.size());
    const std::size_t rounds = std::clamp<std::size_t>(static_cast<std::size_t>(kFaceSteps / step), 1, kMostRounds);
    double stretch = l2_stretch(disk.positions, disk.faces, uv);
    for (std::size_t k = 0; k < rounds && stretch > enough; ++k) {
        std::vector<Vec2d> next = grow_limbs(disk, uv, kSweeps, progress);
        next = descend(disk, std::move(next), 2, kSteps, 1e-3, progress);
        const double now = l2_stretch(disk.positions, disk.faces, next);
        if (!(now < kGain * stretch)) break;
        uv.swap(next);
        stretch = now;
    }
    return uv;
}

}  // namespace dgm::bake
