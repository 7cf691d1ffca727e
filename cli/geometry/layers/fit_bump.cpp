// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/fit_bump.cpp
#include <algorithm>
#include <cmath>

#include "geometry/layers/fit_layers.h"
#include "geometry/layers/grid_least_squares.h"
#include "geometry/metrics/bump_normals.h"
#include "geometry/metrics/grid_point.h"

namespace dgm::bake {
namespace {

/// The class of each texel: those that seams make one. Of two texels that face opposite ways one has the height of the
/// other with the opposite sign.
struct TexelClasses {
    std::vector<std::uint32_t> of;
    std::vector<std::uint8_t> reversed;  ///< empty: none is

    [[nodiscard]] double sign(std::size_t texel) const { return reversed.empty() || !reversed[texel] ? 1 : -1; }
};

TexelClasses classes_of_texels(const SampledChart& chart, std::uint32_t rows, std::uint32_t cols) {
    std::vector<std::uint32_t> sample_class(chart.representative.begin(),
                                            chart.representative.begin() + chart.grid_count());
    for (std::uint32_t s = 0; s < sample_class.size(); ++s)
        if (sample_class[s] >= sample_class.size()) sample_class[s] = s;  // represented by a free chart's border sample
    TexelClasses out;
    out.of = texel_classes(chart.m, chart.n, rows, cols, sample_class, chart.reversed, &out.reversed);
    return out;
}

/// Both sides of a seam take their mean.
void average_classes(const TexelClasses& classes, std::span<double> heights) {
    std::vector<double> sum(heights.size(), 0.0), members(heights.size(), 0.0);
    for (std::size_t t = 0; t < heights.size(); ++t) {
        sum[classes.of[t]] += classes.sign(t) * heights[t];
        members[classes.of[t]] += 1;
    }
    for (std::size_t t = 0; t < heights.size(); ++t)
        heights[t] = classes.sign(t) * (sum[classes.of[t]] / members[classes.of[t]]);
}

/// A matched point: the height it asks of the four texels around it, and its place beside the grid.
struct Gap {
    Vec3d to_source, normal;
};
struct BumpRows {
    std::vector<GridRow<1>> equations;
    std::vector<Gap> gaps;
};

BumpRows rows_of(const LayerInput& in, std::span<const MatchedPoint> points, const StoredPositions& positions,
                 const StoredNormals& normals, std::uint32_t rows, std::uint32_t cols, const TexelClasses& classes,
                 std::span<const double> heights) {
    const SampledChart& chart = in.chart;
    const double down = static_cast<double>(rows - 1) / (chart.m - 1),
                 across = static_cast<double>(cols - 1) / (chart.n - 1);
    BumpRows out;
    out.equations.reserve(points.size());
    out.gaps.reserve(points.size());
    for (const MatchedPoint& p : points) {
        Vec3d grid, normal;
        bool strip = false;
        for (std::size_t k = 0; k < 3; ++k) {
            strip = strip || p.sample[k] >= chart.grid_count();
            grid += positions.local[p.sample[k]] * p.b[k];
            normal += normals.decoded[p.sample[k]] * p.b[k];
        }
        if (strip) continue;
        const Vec2d at = grid_coordinates(chart, p);
        const TexelTaps taps = texel_taps(at.x * down, at.y * across, rows, cols);
        const double h = height_over(grid, normalized(normal), local_position(in, p.at),
                                     normal_of_face(chart.disk->mesh, p.at.face));
        GridRow<1>& row = out.equations.emplace_back();
        row.value[0] = h;
        for (std::size_t k = 0; k < 4; ++k) {
            row.unknown[k] = classes.of[taps.texel[k]];
            row.w[k] = classes.sign(taps.texel[k]) * taps.weight[k];
            row.value[0] -= taps.weight[k] * heights[taps.texel[k]];
        }
        out.gaps.push_back({local_position(in, p.at) - grid, normalized(normal)});
    }
    return out;
}

/// A texel that points touch with a tiny weight could move anywhere: none moves farther than twice the gap there.
void take_step(const BumpRows& rows, std::span<const std::array<double, 1>> step, const TexelClasses& classes,
               std::span<double> heights) {
    std::vector<double> reach(heights.size(), 0.0);
    for (std::size_t k = 0; k < rows.equations.size(); ++k)
        for (const std::uint32_t texel : rows.equations[k].unknown)
            reach[texel] = std::max(reach[texel], 2 * length(rows.gaps[k].to_source));
    for (std::size_t t = 0; t < heights.size(); ++t) {
        const double limit = std::max(reach[classes.of[t]], std::abs(heights[t]));
        heights[t] = std::clamp(heights[t] + classes.sign(t) * step[classes.of[t]][0], -limit, limit);
        if (!std::isfinite(heights[t])) heights[t] = 0;
    }
}

/// Where the grid is sheared or its normals lean, heights along them may lead away from the source, and texels that no
/// point touches may hold anything: none is better.
void drop_useless(const BumpRows& rows, const TexelClasses& classes, std::span<double> heights) {
    std::vector<double> gain(heights.size(), 0.0);
    for (std::size_t k = 0; k < rows.equations.size(); ++k) {
        const GridRow<1>& row = rows.equations[k];
        const Gap& gap = rows.gaps[k];
        double h = 0;
        for (std::size_t c = 0; c < 4; ++c) h += row.w[c] * heights[row.unknown[c]];
        const Vec3d rest = gap.to_source - gap.normal * h;
        const double better = dot(gap.to_source, gap.to_source) - dot(rest, rest);
        for (std::size_t c = 0; c < 4; ++c) gain[row.unknown[c]] += std::abs(row.w[c]) * better;
    }
    for (std::size_t t = 0; t < heights.size(); ++t)
        if (!(gain[classes.of[t]] > 0)) heights[t] = 0;
}

}  // namespace

double height_over(const Vec3d& grid, const Vec3d& normal, const Vec3d& point, const Vec3d& plane) {
    constexpr double kSteep = 0.5;
    const Vec3d gap = point - grid;
    const double cosine = dot(normal, plane), limit = 2 * length(gap);
    return cosine > kSteep ? std::clamp(dot(gap, plane) / cosine, -limit, limit) : dot(gap, normal);
}

void fit_bump(const LayerInput& in, std::span<const MatchedPoint> points, const StoredPositions& positions,
              const StoredNormals& normals, std::uint32_t rows, std::uint32_t cols, std::span<double> heights) {
    // As much as the points: with one or two of them a texel, less follows their scatter, and the normals suffer.
    constexpr double kDamping = 1;
    constexpr int kIterations = 15, kJudgements = 3;
    if (rows < 2 || cols < 2) return;
    const TexelClasses classes = classes_of_texels(in.chart, rows, cols);
    average_classes(classes, heights);
    const BumpRows bump = rows_of(in, points, positions, normals, rows, cols, classes, heights);
    take_step(bump, grid_least_squares<1>(bump.equations, heights.size(), kDamping, kIterations), classes, heights);
    for (int pass = 0; pass < kJudgements; ++pass) drop_useless(bump, classes, heights);
}

}  // namespace dgm::bake
