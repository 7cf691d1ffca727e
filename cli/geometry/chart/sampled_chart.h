// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/sampled_chart.h
// A component on its grid: the result of cut, map and resampling, before layers are made of it.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <dgm/layout.h>

#include "geometry/chart/shared_disk.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/metrics/surface_error.h"
#include "geometry/resample/rasterize.h"
#include "geometry/spatial/closest_point.h"

namespace dgm::bake {

/// The places that u16 positions can have: a low corner and 65535 equal steps along each axis, normalised frame.
struct Lattice {
    Vec3d low;
    double step = 0;
    static constexpr double kCodes = 65535;

    [[nodiscard]] Vec3d nearest(const Vec3d& p) const;
    [[nodiscard]] bool holds(const Vec3d& p) const;
};

/// Samples are numbered as in the file: i*n+j on the grid, then m*n+b for the border samples of a free domain.
struct SampledChart {
    std::uint32_t m = 0, n = 0;
    layout::Domain domain = layout::Domain::kSquare;
    std::string method;
    SharedDisk disk;                            ///< split as the border needed it
    std::vector<Vec2d> uv;                      ///< the map, per vertex of `disk`
    std::vector<SurfaceSample> samples;         ///< where each sample lies; face kNone off the surface
    std::vector<Vec3d> positions;               ///< normalised frame; copies of a class are equal to the bit
    std::vector<std::uint32_t> representative;  ///< lowest sample of the class, itself if alone
    std::vector<std::uint8_t> reversed;  ///< 1 where a copy faces the other way than its representative; empty: nowhere
    std::vector<std::uint8_t> diagonals;  ///< (m-1)*(n-1)
    std::vector<std::uint8_t> mask;       ///< m*n; free domain only
    std::vector<Vec2d> border_uv;         ///< free domain only, per border sample
    std::vector<Face> strip;              ///< free domain only: triangles between lattice and border
    std::optional<Lattice> lattice;       ///< that the positions of the grid lie on, if they were put on one
    double cut_length = 0;
    std::string note;  ///< losses that the method had to accept, in plain words; usually empty

    [[nodiscard]] std::size_t grid_count() const { return std::size_t{m} * n; }
    [[nodiscard]] bool is_reversed(std::size_t sample) const { return !reversed.empty() && reversed[sample] != 0; }
    [[nodiscard]] bool on_surface(std::size_t sample) const {
        return mask.empty() || sample >= grid_count() || mask[sample] != 0;
    }
    /// True if quad (i, j) is drawn: all four corners on the surface.
    [[nodiscard]] bool has_quad(std::uint32_t i, std::uint32_t j) const;
    /// Triangles of the grid surface: quads split by `diagonals`, then the strip.
    [[nodiscard]] std::vector<Face> faces() const;
    /// The surface as a mesh over `positions`, seam copies kept apart.
    [[nodiscard]] TriMesh surface() const;
};

/// Chooses each quad's diagonal: the one that splits it soundly, or the one whose middle is closer to the surface point
/// that the map has there; `centres` is the rasterization at (2m-1) x (2n-1). A diagonal that the welded surface has
/// already, or between two copies of one class, is not taken where the other one is free.
void choose_diagonals(SampledChart& chart, const SampleGrid& centres);

/// True if the two triangles that `diagonal` makes of quad (i, j) look away from each other: the quad is an arrowhead
/// (or bends by more than a right angle), and this diagonal lies outside of it. Or if one of them has hardly a height,
/// as at a corner of the map where the border is straight: rounding would choose the side that it faces.
[[nodiscard]] bool splits_badly(const SampledChart& chart, std::uint32_t i, std::uint32_t j, unsigned diagonal);

/// The smallest lattice around all samples on the surface.
[[nodiscard]] Lattice lattice_around(const SampledChart& chart);

/// Triangles of the grid that face against the surface at all their corners: shear in the map inverts quads on a bent
/// surface. A quick stand-in for turned_faces.h while samples lie where the map put them.
[[nodiscard]] std::size_t count_folded(const SampledChart& chart);

/// Positions of all samples from their surface points, classes from their representative.
void place_samples(SampledChart& chart);

/// Every second sample of a (2m-1) x (2n-1) rasterization: the m x n grid itself.
[[nodiscard]] std::vector<SurfaceSample> coarsen(const SampleGrid& fine, std::uint32_t m, std::uint32_t n);

/// Topology of the chart's surface with its seams closed: it must be that of the component.
[[nodiscard]] Topology welded_topology(const SampledChart& chart);

/// True if a welded surface is the manifold that its source is: a chart must pass this before it is used.
[[nodiscard]] bool holds_topology(const Topology& welded, const Topology& source);

/// Error of the chart's surface against its component with few samples, by which candidates are compared.
/// @param source_index  of the component; null: one is built for this
[[nodiscard]] SurfaceError quick_error(const TriMesh& component, const SampledChart& chart, std::uint64_t samples,
                                       const ClosestPointIndex* source_index = nullptr);

}  // namespace dgm::bake
