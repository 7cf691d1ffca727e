// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/fit_work.h
// What one fit may cost where nothing says otherwise.
#pragma once
#include <cstddef>
#include <cstdint>

namespace dgm::bake {

/// Source points of a small grid, up to three times as many a sample as a large one has.
inline constexpr std::size_t kPointsOfSmall = 200'000;
/// Samples of a grid on which a pass over all of it costs so much that less is done where that does.
inline constexpr std::size_t kLargeGrid = 30'000;
/// Samples that repairs of patches may move: some seconds at most.
inline constexpr std::size_t kPatchEffort = 500'000;
/// Points on each surface where charts of a component are compared.
inline constexpr std::uint64_t kTrialSamples = 20'000;

}  // namespace dgm::bake
