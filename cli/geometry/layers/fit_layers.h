// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/fit_layers.h
// Layers of a fitted chart, each least-squares fitted at its own resolution from where sampling left it: so that values
// interpolated between samples or texels come closest to the source, in the mean over its area.
#pragma once
#include <span>
#include <vector>

#include "geometry/layers/layers.h"
#include "geometry/layers/source_match.h"

namespace dgm::bake {

/// Moves the normals so that their interpolation over the grid triangles, renormalised as in a shader, has the least
/// mean squared deviation from the source's. Copies of a class are one unknown. The octahedral code's own error, 0.004
/// degrees at most, is left to rounding. Kept only where the points agree that it is better.
void fit_normals(const LayerInput& in, std::span<const MatchedPoint> points, StoredNormals& normals);

/// RGBA texels, `colours` per point. In the encoded sRGB values, since readers of a u8 picture interpolate those; a
/// texel stays within the range of the colours around it, so edges do not ring, and keeps its sampled value where no
/// point falls.
void fit_texture(const LayerInput& in, std::span<const MatchedPoint> points,
                 std::span<const std::array<double, 4>> colours, std::uint32_t rows, std::uint32_t cols,
                 std::span<std::uint8_t> rgba);

/// Heights, source units: interpolated bilinearly, along the interpolated decoded normal. Texels of one seam point
/// are one unknown; points over a border strip, which bump does not cover, are left out.
void fit_bump(const LayerInput& in, std::span<const MatchedPoint> points, const StoredPositions& positions,
              const StoredNormals& normals, std::uint32_t rows, std::uint32_t cols, std::span<double> heights);

/// Height over a point of the grid along `normal` at which the plane through `point` of the source is met; the plain
/// projection where that plane is steep. At most twice the distance.
[[nodiscard]] double height_over(const Vec3d& grid, const Vec3d& normal, const Vec3d& point, const Vec3d& plane);

}  // namespace dgm::bake
