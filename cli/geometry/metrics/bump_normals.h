// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/metrics/bump_normals.h
// Shading with the layer `bump`: normals of the displaced surface, beside those of the layer `normal`.
//
// The plain rule of [Blinn 1978], normal minus gradient of the height, counts the curvature between two samples twice:
// it is in the interpolated stored normals and in the heights. So the normals of the displaced surface stand beside the
// stored ones, and the file stores the weight of each:
//
//     n(u, v) = normalize( (1 - w) n_stored + w n_fine ),   w = attribute `shading` of the layer
//
// n_fine are the vertex normals of the displaced texel lattice, weighted as [Max 1999] (exact on spheres, whatever the
// spacing) and summed over all copies of a seam point, interpolated bilinearly. The baker chooses the w in [0, 1] that
// comes closest to the source's normals: near 1 where the grid is coarser than the source's detail, near 0 where the
// source itself is a smoothly shaded polyhedron, whose facets are in the heights but not in its normals.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "geometry/metrics/reconstruction.h"

namespace dgm::bake {

/// Texels that are one and the same surface point, as the lowest of them; `sample_class` likewise for the m x n grid
/// samples. Known where texels fall on samples and at equal fractions between them, that is if rows-1 and cols-1 are
/// multiples of m-1 and n-1; else, and inside the chart, each texel is its own.
///
/// With `sample_reversed` (1 where a sample faces the other way than its class), `reversed` becomes 1 where a texel
/// faces the other way than the lowest of its class: its height has the other sign.
[[nodiscard]] std::vector<std::uint32_t> texel_classes(std::uint32_t m, std::uint32_t n, std::uint32_t rows,
                                                       std::uint32_t cols, std::span<const std::uint32_t> sample_class,
                                                       std::span<const std::uint8_t> sample_reversed = {},
                                                       std::vector<std::uint8_t>* reversed = nullptr);

class BumpNormals {
 public:
    /// Nothing if the chart has no bump of at least 2 x 2 texels, or no normals. `surface` must be the chart's.
    [[nodiscard]] static std::optional<BumpNormals> of(const model::Chart& chart, const Reconstruction& surface);

    /// Unit normal at a point of a face of the reconstruction; the stored one on border strips. Zero if that has none.
    [[nodiscard]] model::Vec3d at(std::uint32_t face, const double (&barycentric)[3]) const;
    /// n_stored and n_fine there, unit vectors; n_fine is zero where there is none.
    struct Both {
        model::Vec3d stored, fine;
    };
    [[nodiscard]] Both both(std::uint32_t face, const double (&barycentric)[3]) const;
    /// The normal that at() gives on texel `texel` of the layer, row-major; zero where no quad lies under it.
    [[nodiscard]] model::Vec3d at_texel(std::size_t texel) const;

 private:
    BumpNormals(const model::Chart& chart, const Reconstruction& surface);
    [[nodiscard]] std::vector<model::Vec3d> fine_normals(const std::vector<model::Vec3d>& fine,
                                                         const std::vector<char>& valid) const;
    [[nodiscard]] model::Vec3d blend(const Both& n) const;

    const Reconstruction& surface_;
    std::uint32_t m_, n_, rows_ = 0, cols_ = 0;
    double weight_ = 0;
    std::vector<model::Vec3d> fine_;    // n_fine, per texel; zero where there is no lattice
    std::vector<model::Vec3d> stored_;  // n_stored, per texel; zero where no quad is
};

}  // namespace dgm::bake
