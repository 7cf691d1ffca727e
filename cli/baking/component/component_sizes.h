// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/component_sizes.h
// Shares the samples of an asset among its components.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "baking/bake_options.h"

namespace dgm::bake {

/// Samples a side that every grid has at least, and where there are so many grids that these come to more than all may
/// have and to more than 425,000: most of such parts are a few faces each. With layers below 100 bytes HDF5 looks for
/// room among all gaps of a file, for each of its structures: thousands of grids of 9 x 9 took minutes to write.
inline constexpr std::uint32_t kLeastSide = 17, kLeastSideOfMany = 11;

/// Grid of a component: `full` for the largest one, for others the same spacing of samples, but not under `least` a
/// side.
[[nodiscard]] GridSize component_size(GridSize full, double area, double largest_area,
                                      std::uint32_t least = kLeastSide);

/// component_size() of every component; `full` as above, one each. The grids of all but the largest are smaller where
/// they would hold more than 10 times its samples, or 7 times where 10 are more than 460,000: a soup of a hundred
/// pieces as large as each other is not worth a hundred times the time and space. The least grids may come to more.
[[nodiscard]] std::vector<GridSize> component_sizes(std::span<const GridSize> full, std::span<const double> areas,
                                                    std::size_t largest);

}  // namespace dgm::bake
