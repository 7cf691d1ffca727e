// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/percentile.h
// Finds the end of a colour scale, so that single far values do not take the colour from all others.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace dgm::render {

/// The value below which `share` (0..1) of the values lie; 0 for none.
[[nodiscard]] inline double percentile(std::vector<double> values, double share) {
    if (values.empty()) return 0;
    const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + rank, values.end());
    return values[static_cast<std::size_t>(rank)];
}

}  // namespace dgm::render
