// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/chart_effort.cpp
#include "baking/chart_effort.h"

#include <algorithm>
#include <cmath>

#include "geometry/fit/fit.h"

namespace dgm::bake {
namespace {

/// A chart's share of `whole`, from `least` to `most`.
std::size_t share(std::size_t whole, std::size_t charts, std::size_t least, std::size_t most) {
    return std::clamp(whole / std::max<std::size_t>(charts, 1), least, most);
}

}  // namespace

ChartEffort chart_effort(std::size_t charts, double samples) {
    constexpr std::size_t kFew = 10, kMany = 20;
    constexpr double kGridsOfMany = 4;  // as large as the largest, whose rounds are done in full
    constexpr double kLeastRounds = 0.5;
    ChartEffort out;
    out.trial_samples = share(50 * kTrialSamples, charts, kTrialSamples / 100, kTrialSamples);
    out.measured_samples = share(500 * kLeastMeasured, charts, kLeastMeasured / 10, kLeastMeasured);
    out.points_of_small = share(20 * kPointsOfSmall, charts, 1, kPointsOfSmall);
    out.patch_effort = share(4 * kPatchEffort, charts, kPatchEffort / 50, kPatchEffort);
    const double many = std::clamp((static_cast<double>(charts) - kFew) / (kMany - kFew), 0.0, 1.0);
    out.rounds = 1 - many * (1 - std::clamp(kGridsOfMany / std::max(samples, 1.0), kLeastRounds, 1.0));
    return out;
}

FitOptions with_effort(FitOptions options, const ChartEffort& effort) {
    options.trial_samples = effort.trial_samples;
    options.patch_effort = effort.patch_effort;
    options.points_of_small = effort.points_of_small;
    // Of 20 shells: one snap less of two costs 2.1 dB, half the rounds 0.3. Sheets at 140 dB lose 2.
    for (int* const count : {&options.rounds, &options.worst_rounds})
        if (*count > 0) *count = std::max(1, static_cast<int>(std::lround(*count * effort.rounds)));
    return options;
}

}  // namespace dgm::bake
