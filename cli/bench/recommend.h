// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/recommend.h
// Puts the advice of a bake sweep's figures into words.
#pragma once
#include <string>
#include <vector>

#include "bench/table.h"

namespace dgm::bench {

/// For each error of a fixed ladder (1 % .. 0.001 % rms) that a point of `asset` holds and a coarser rung's answer does
/// not: the point with the fewest bytes (then the least CPU time), and what other methods need:
/// "for 0.05 % rms use 129x129 auto u16: 0.31 MB, 0.9 s; arap needs 257x257; lscm does not reach it".
/// "Needs at most" where no grid of half the side was tried. Only points with the layers of the first row count.
/// `table` is that of a bake sweep (bake_sweep.h).
[[nodiscard]] std::vector<std::string> recommend(const Table& table, const std::string& asset);

/// "arap", "arap and lscm", "arap, lscm and mvc".
[[nodiscard]] std::string listed(const std::vector<std::string>& names);

}  // namespace dgm::bench
