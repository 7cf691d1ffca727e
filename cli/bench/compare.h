// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/compare.h
#pragma once
#include <string>
#include <vector>

#include "bench/table.h"

namespace dgm::bench {

/// Figures that got faster, slower, better or worse beyond the noise since `then`: a line each, most changed first. A
/// last line counts the figures within the noise, those with too few repetitions, and the points that only one of the
/// runs has. Times of different machines are not compared, and a line says so.
/// @throws model::Error kUsage if the runs are of different commands
[[nodiscard]] std::vector<std::string> compare_runs(const Run& now, const Run& then);

}  // namespace dgm::bench
