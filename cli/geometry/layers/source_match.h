// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/source_match.h
// Points spread evenly over the source, each with the point of the stored grid surface that stands for it. The layers
// of a fitted chart are fitted to them.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "geometry/layers/layers.h"

namespace dgm::bake {

struct MatchedPoint {
    SurfaceSample at;                       ///< on a face of chart.disk
    std::uint32_t face = kNone;             ///< of the stored surface, as numbered in the file
    std::array<std::uint32_t, 3> sample{};  ///< corners of the grid triangle, or of a triangle of the strip
    std::array<double, 3> b{};              ///< weights of those
};

/// Position, source units, in the local frame of the stored positions.
[[nodiscard]] Vec3d local_position(const LayerInput& in, const SurfaceSample& at);
/// The source's unit normal there: its corners' interpolated, else the face's; zero where there is none.
[[nodiscard]] Vec3d source_normal(const TriMesh& mesh, const SurfaceSample& at);
/// The unit normal of the face alone.
[[nodiscard]] Vec3d normal_of_face(const TriMesh& mesh, std::uint32_t face);

/// Row and column of a matched point in units of samples; for strip triangles by `border_uv`.
[[nodiscard]] Vec2d grid_coordinates(const SampledChart& chart, const MatchedPoint& p);

/// About `count` points, each at the middle of its equal share of the area, matched to the closest point of the surface
/// through `positions.local` whose face looks the same way. Points whose match is much farther than the closest point
/// of all are left out: they belong to another sheet. Deterministic, whatever the number of threads.
[[nodiscard]] std::vector<MatchedPoint> match_source(const LayerInput& in, const StoredPositions& positions,
                                                     std::size_t count);

}  // namespace dgm::bake
