// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/chart_effort.h
// How much work one chart of many may cost. Counted, never timed, so that bytes are the same on every machine.
#pragma once
#include <cstddef>
#include <cstdint>

#include "geometry/fit/fit_work.h"

namespace dgm::bake {

struct FitOptions;

/// Points on each surface where a chart is measured at least.
inline constexpr std::uint64_t kLeastMeasured = 2'000;

/// Charts of an asset share what one with a few charts may cost; up to ten have all of it each.
struct ChartEffort {
    std::uint64_t trial_samples = kTrialSamples;  ///< FitOptions's
    std::uint64_t measured_samples = kLeastMeasured;
    std::size_t points_of_small = kPointsOfSmall;  ///< FitOptions's
    std::size_t patch_effort = kPatchEffort;       ///< FitOptions's
    double rounds = 1;                             ///< part of the rounds of a fit
};

/// @param charts   of the asset
/// @param samples  of all their grids, over those of the largest
[[nodiscard]] ChartEffort chart_effort(std::size_t charts, double samples);

/// The options of a fit with that effort.
[[nodiscard]] FitOptions with_effort(FitOptions options, const ChartEffort& effort);

}  // namespace dgm::bake
