// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/component_shapes.h
// Finds the m : n that suits each component of an asset, by cheap bakes (--size auto:N).
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "baking/component/component_bake.h"

namespace dgm::bake {

struct ComponentShapes {
    std::vector<double> aspects;    ///< (rows - 1) : (cols - 1), per component
    std::vector<GridTrial> trials;  ///< cheap bakes of the largest component; rms in normalised units
};

/// choose_aspect for the largest component, and for others that get enough samples for a shape to matter; small ones
/// are square. `samples` is the largest component's; the trials take at most 65 x 65.
/// A grid without a valid map only loses.
/// @throws model::Error of a component that cannot be baked for another reason; kInterrupted
[[nodiscard]] ComponentShapes choose_component_shapes(std::span<const model::TriMesh> components,
                                                      std::span<const double> areas, std::uint64_t samples,
                                                      const BakeOptions& options, std::span<CutMemory> cuts,
                                                      const model::Progress& progress);

/// Height : width of a free chart before it was stretched over the square: how much longer a step along the rows'
/// direction is on the surface than one along the columns', root mean square over the surface.
[[nodiscard]] double free_chart_aspect(const SampledChart& chart);

}  // namespace dgm::bake
