// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/free_chart.h
// A disk anywhere inside the square (docs/design.md section 3): mask, border samples and the strip that joins them.
#pragma once
#include <functional>
#include <span>
#include <utility>

#include "geometry/chart/sampled_chart.h"
#include "geometry/parameterize/parameterizer.h"

namespace dgm::bake {

/// Triangles of the region between the outer border and the holes: an edge is a pair of point indices; faces that an
/// odd number of constraints separates from the outside, counter-clockwise.
/// @throws model::Error kMapInvalid if constraints cross
using Triangulate = std::function<std::vector<Face>(
    std::span<const Vec2d> points, std::span<const std::pair<std::uint32_t, std::uint32_t>> constraints)>;

struct FreeChartTools {
    std::function<bool(std::span<const Vec2d> border)> is_simple;
    Triangulate triangulate;
    int cut_rounds = 8;  ///< cuts mapped, at most
};

/// Cuts, solves, checks (finite, flips, degenerate faces, simple border), turns the chart to its smallest rectangle,
/// stretches that over the square, and samples it. The cut is the shortest that opens the component, and for closed
/// bodies its tips; while the map overlaps itself or is stretched much, the vertices farthest from the cut are joined
/// to it. A chart that no cut makes valid is laid out with a convex border of the same edge lengths, and says so in
/// `note`.
///
/// Every vertex of the chart's border is a border sample; border edges longer than a grid cell on either side of a cut
/// are divided on both sides at the same places (within a bound: fit_to_square.h). A quad is kept only where no border
/// edge enters it, so a slit thinner than a cell stays a slit.
/// @throws model::Error kMapInvalid, kInterrupted
[[nodiscard]] SampledChart make_free_chart(const TriMesh& component, std::uint32_t m, std::uint32_t n,
                                           const Parameterizer& method, const FreeChartTools& tools,
                                           const model::Progress& progress);

/// The same for a component that was cut already: the cut is kept as it is.
[[nodiscard]] SampledChart make_free_chart(Disk disk, std::uint32_t m, std::uint32_t n, const Parameterizer& method,
                                           const FreeChartTools& tools, const model::Progress& progress);

/// Method `uv`: the component opened where its texture coordinates part, laid out by them.
/// @throws model::Error kMethodUnsuited if there are no UVs, or they are not one valid chart
[[nodiscard]] SampledChart make_uv_chart(const TriMesh& component, std::uint32_t m, std::uint32_t n,
                                         const FreeChartTools& tools, const model::Progress& progress);

}  // namespace dgm::bake
