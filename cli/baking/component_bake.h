// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component_bake.h
// One component to one sampled chart: which candidates are tried, and which is kept.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "baking/bake_options.h"
#include "baking/bake_report.h"
#include "baking/cut_memory.h"
#include "geometry/chart/sampled_chart.h"

namespace dgm::bake {

struct ComponentResult {
    SampledChart chart;
    std::vector<CandidateReport> candidates;
};

/// `auto` tries the methods that fit the component and keeps the one with the least measured error; a named method is
/// tried alone. The grid grows (doubling, up to `most`) from `size` where the cut does not fit it. `cuts` remembers
/// what was found for the same component, and says whether that may be used again.
/// @throws model::Error kMapInvalid, kMethodUnsuited, kGridTooSmall, kInterrupted
[[nodiscard]] ComponentResult bake_component(const model::TriMesh& component, GridSize size, GridSize most,
                                             const BakeOptions& options, CutMemory& cuts,
                                             const model::Progress& progress);

/// Grid of a component: `full` for the largest one, for others the same spacing of samples, but not under 17 a side.
[[nodiscard]] GridSize component_size(GridSize full, double area, double largest_area);

/// component_size() of every component; `full` as above, one each. The grids of all but the largest are smaller where
/// they would hold more than 10 times its samples: a soup of a hundred pieces as large as each other is not worth a
/// hundred times the time and space. The least grids may come to more than that.
[[nodiscard]] std::vector<GridSize> component_sizes(std::span<const GridSize> full, std::span<const double> areas,
                                                    std::size_t largest);

}  // namespace dgm::bake
