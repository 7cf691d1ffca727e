// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/resample/rasterize.h
// Finds the point of the surface on which each sample of an m x n grid stands.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/parameterize/square_border.h"

namespace dgm::bake {

/// m*n samples, row-major; face is kNone where no triangle covers the sample.
struct SampleGrid {
    std::uint32_t m = 0, n = 0;
    std::vector<SurfaceSample> samples;
    std::uint64_t missing = 0;  ///< samples no triangle covers (square domain: must be 0)
};

/// Covers every sample (i/(m-1), j/(n-1)) by the lowest-numbered triangle whose closed map triangle holds it, decided
/// by the exact orientation predicate in grid coordinates: no holes between neighbours, no double hits.
[[nodiscard]] SampleGrid rasterize(std::span<const Face> faces, std::span<const Vec2d> uv, std::uint32_t m,
                                   std::uint32_t n);

/// `count` points spread evenly by area, in the order of the faces: the k-th at share (k + 1/2) / count of the area,
/// inside its face by the R2 sequence, so the same mesh gives the same points. None if the mesh has no area.
[[nodiscard]] std::vector<SurfaceSample> spread_by_area(const TriMesh& mesh, std::size_t count);

}  // namespace dgm::bake
