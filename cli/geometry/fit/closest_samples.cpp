// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/closest_samples.cpp
#include "geometry/fit/closest_samples.h"

#include <tbb/parallel_for.h>

#include <dgm/grid.h>
#include <algorithm>
#include <cmath>

#include "geometry/fit/linked_surface.h"
#include "geometry/spatial/closest_point.h"

namespace dgm::bake {
namespace {

/// A point of the chart's surface to look up on the source.
struct Query {
    Vec3d point, normal;
    std::uint32_t start = kNone;  ///< face of the source to walk from
    bool on_surface = false;
};

/// Row r and column c of a rows x cols grid, on the triangle of the chart's own grid under it.
Query query_at(const SampledChart& chart, std::uint32_t r, std::uint32_t c, std::uint32_t rows, std::uint32_t cols) {
    const double x = static_cast<double>(r) * (chart.m - 1) / std::max(1u, rows - 1);
    const double y = static_cast<double>(c) * (chart.n - 1) / std::max(1u, cols - 1);
    const auto i = std::min(static_cast<std::uint32_t>(x), chart.m - 2),
               j = std::min(static_cast<std::uint32_t>(y), chart.n - 2);
    if (!chart.has_quad(i, j)) return {};
    const double s = x - i, t = y - j;
    const unsigned diagonal = chart.diagonals[std::size_t{i} * (chart.n - 1) + j];
    const auto triangles = quad_triangles(i, j, chart.n, diagonal);
    // (0,0) (1,0) (1,1) | (0,0) (1,1) (0,1)   or   (0,0) (1,0) (0,1) | (1,0) (1,1) (0,1)
    const bool second = diagonal == 0 ? t > s : s + t > 1;
    const Face& f = triangles[second];
    const std::array<double, 3> b = diagonal == 0 ? second ? std::array{1 - t, s, t - s} : std::array{1 - s, s - t, t}
                                    : second ? std::array{1 - t, s + t - 1, 1 - s}
                                                  : std::array{1 - s - t, s, t};
    const Vec3d &p = chart.positions[f[0]], &q = chart.positions[f[1]], &w = chart.positions[f[2]];
    const std::size_t nearest = b[0] >= b[1] && b[0] >= b[2] ? 0 : b[1] >= b[2] ? 1 : 2;
    return {p * b[0] + q * b[1] + w * b[2], normalized(cross(q - p, w - p), Vec3d{}), chart.samples[f[nearest]].face,
            true};
}

}  // namespace

SampleGrid closest_samples(const SampledChart& chart, std::uint32_t rows, std::uint32_t cols) {
    constexpr double kMinCosine = 0.3;  // as ClosestPointIndex::query_preferring
    SampleGrid grid{rows, cols, std::vector<SurfaceSample>(std::size_t{rows} * cols)};
    const LinkedSurface source = link_source(*chart.disk);
    const double slack = 0.25 * std::sqrt(surface_area(source) / static_cast<double>(chart.grid_count()));
    // A walk from the sample beside the point ends close by, or the index tells; over a source finer than the grid a
    // walk would stop at the first bump.
    const bool walks = source.faces.size() <= 2 * chart.grid_count();
    std::vector<char> open(grid.samples.size(), 0);
    tbb::parallel_for(std::uint32_t{0}, rows, [&](std::uint32_t r) {
        for (std::uint32_t c = 0; c < cols; ++c) {
            const Query at = query_at(chart, r, c, rows, cols);
            if (!at.on_surface) continue;
            const std::size_t s = std::size_t{r} * cols + c;
            if (walks && at.start != kNone) {
                const SurfaceHit hit = walk_to_closest(source, at.point, at.start);
                if (hit.squared <= slack * slack && dot(source.normals[hit.face], at.normal) > kMinCosine) {
                    grid.samples[s] = {hit.face, {hit.b[0], hit.b[1], hit.b[2]}};
                    continue;
                }
            }
            open[s] = 1;
        }
    });
    if (std::find(open.begin(), open.end(), 1) != open.end()) {
        const ClosestPointIndex& index = chart.disk.index();
        tbb::parallel_for(std::uint32_t{0}, rows, [&](std::uint32_t r) {
            for (std::uint32_t c = 0; c < cols; ++c) {
                const std::size_t s = std::size_t{r} * cols + c;
                if (!open[s]) continue;
                const Query at = query_at(chart, r, c, rows, cols);
                const ClosestPoint hit = index.query_preferring(at.point, at.normal, slack, at.start);
                grid.samples[s] = {hit.face, {hit.barycentric[0], hit.barycentric[1], hit.barycentric[2]}};
            }
        });
    }
    for (const SurfaceSample& s : grid.samples) grid.missing += s.face == kNone;
    return grid;
}

}  // namespace dgm::bake
