// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/pareto.h
#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace dgm::bench {

struct Cost {
    double x = 0, y = 0;  ///< less is better of both
};

/// Indices of the points that no other beats: none has both coordinates at most as large and one smaller. By rising x;
/// of equal points the first. Points that are not finite take no part.
[[nodiscard]] std::vector<std::size_t> pareto_front(std::span<const Cost> points);

}  // namespace dgm::bench
