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
    std::vector<RingUse> rings;     ///< per component: kOnly or kNot where the trials leave no doubt
    std::vector<GridTrial> trials;  ///< cheap bakes of the largest component; rms in normalised units
};

/// choose_aspect for the largest component, and for others that get enough samples for a shape to matter; small ones
/// are square. `samples` is the largest component's; trials take at most 65 x 65. A ring is tried as it unrolls too, up
/// to 16:1, and a long surface from its own length : width on, up to 64:1. Errors are those after a trial fit if there
/// will be a fit. A grid without a valid map only loses.
/// @throws model::Error of a component that cannot be baked for another reason; kInterrupted
[[nodiscard]] ComponentShapes choose_component_shapes(std::span<const model::TriMesh> components,
                                                      std::span<const double> areas, std::uint64_t samples,
                                                      const BakeOptions& options, std::span<CutMemory> cuts,
                                                      const model::Progress& progress);

/// Rings and long surfaces of at most 100,000 faces alone: the aspect in which a ring's unrolled chart, or any of a
/// long surface, has much less error, after a trial fit, than a square grid of as many samples has; 1 where there is
/// none such, and for other components. As choose_component_shapes for the rest.
[[nodiscard]] ComponentShapes choose_unasked_shapes(std::span<const model::TriMesh> components,
                                                    std::span<const double> areas, std::uint64_t samples,
                                                    const BakeOptions& options, std::span<CutMemory> cuts,
                                                    const model::Progress& progress);

/// How many times as long as wide a surface is that is long as a strip or a tube is, which a long grid suits: the
/// square of the longest way over it, along edges, over its area, where that is more than 4 and nothing lies far from
/// that way. 1 for others, trees of limbs among them.
[[nodiscard]] double strip_length(const model::TriMesh& component);

/// Height : width of a free chart before it was stretched over the square: how much longer a step along the rows'
/// direction is on the surface than one along the columns', root mean square over the surface.
[[nodiscard]] double free_chart_aspect(const SampledChart& chart);

}  // namespace dgm::bake
