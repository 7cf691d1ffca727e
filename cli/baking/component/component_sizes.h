// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/component_sizes.h
// Shares the samples of an asset among its components.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "baking/bake_options.h"

namespace dgm::bake {

/// Grid of a component: `full` for the largest one, for others the same spacing of samples, but not under 17 a side.
[[nodiscard]] GridSize component_size(GridSize full, double area, double largest_area);

/// component_size() of every component; `full` as above, one each. The grids of all but the largest are smaller where
/// they would hold more than 10 times its samples: a soup of a hundred pieces as large as each other is not worth a
/// hundred times the time and space. The least grids may come to more than that.
[[nodiscard]] std::vector<GridSize> component_sizes(std::span<const GridSize> full, std::span<const double> areas,
                                                    std::size_t largest);

}  // namespace dgm::bake
