// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/resample/rasterize.cpp
#include "geometry/resample/rasterize.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/mesh/infinity.h"
#include "geometry/metrics/map_metrics.h"

namespace dgm::bake {
namespace {

/// Whole numbers in `range` that row x may have inside the triangle, and at most one or two more: the box of a needle
/// that lies across the grid is nearly empty.
std::pair<double, double> narrowed(const Vec2d (&p)[3], double x, std::pair<double, double> range) {
    double lo = kInfinity, hi = -kInfinity;
    for (int k = 0; k < 3; ++k) {
        const Vec2d &a = p[k], &b = p[(k + 1) % 3];
        if (std::min(a.x, b.x) > x || std::max(a.x, b.x) < x) continue;
        if (std::abs(b.x - a.x) < 1e-6) {  // too steep for a certain crossing
            lo = std::min({lo, a.y, b.y});
            hi = std::max({hi, a.y, b.y});
            continue;
        }
        const double y = a.y + (b.y - a.y) * ((x - a.x) / (b.x - a.x));
        lo = std::min(lo, y);
        hi = std::max(hi, y);
    }
    return {std::max(range.first, std::floor(lo)), std::min(range.second, std::ceil(hi))};
}

/// Fraction of a number that is not negative.
double fraction(double x) {
    return x - std::floor(x);
}

}  // namespace

SampleGrid rasterize(std::span<const Face> faces, std::span<const Vec2d> uv, std::uint32_t m, std::uint32_t n) {
    SampleGrid grid{m, n, std::vector<SurfaceSample>(std::size_t{m} * n)};
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        Vec2d p[3];
        for (int k = 0; k < 3; ++k) p[k] = {uv[faces[f][k]].x * (m - 1), uv[faces[f][k]].y * (n - 1)};
        if (orient2d(p[0], p[1], p[2]) <= 0) continue;  // counted by the caller; a valid map has none
        const double lo_x = std::ceil(std::min({p[0].x, p[1].x, p[2].x})),
                     hi_x = std::floor(std::max({p[0].x, p[1].x, p[2].x}));
        const double lo_y = std::ceil(std::min({p[0].y, p[1].y, p[2].y})),
                     hi_y = std::floor(std::max({p[0].y, p[1].y, p[2].y}));
        const std::pair<double, double> column{std::max(lo_y, 0.0), std::min(hi_y, n - 1.0)};
        const bool narrow = column.second - column.first < 4;
        for (double x = std::max(lo_x, 0.0); x <= std::min(hi_x, m - 1.0); ++x) {
            const auto [from, to] = narrow ? column : narrowed(p, x, column);
            for (double y = from; y <= to; ++y) {
                SurfaceSample& s = grid.samples[static_cast<std::size_t>(x) * n + static_cast<std::size_t>(y)];
                if (s.face != kNone) continue;
                const Vec2d c{x, y};
                if (orient2d(p[0], p[1], c) < 0 || orient2d(p[1], p[2], c) < 0 || orient2d(p[2], p[0], c) < 0) continue;
                s.face = f;
                double sum = 0;
                for (int k = 0; k < 3; ++k) {
                    s.b[k] = std::max(0.0, cross(p[(k + 1) % 3] - c, p[(k + 2) % 3] - c));
                    sum += s.b[k];
                }
                if (sum > 0)
                    for (double& b : s.b) b /= sum;
                else
                    s.b[0] = 1;
            }
        }
    }
    for (const SurfaceSample& s : grid.samples) grid.missing += s.face == kNone;
    return grid;
}

std::vector<SurfaceSample> spread_by_area(const TriMesh& mesh, std::size_t count) {
    std::vector<double> upto(mesh.faces.size() + 1, 0.0);
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) upto[f + 1] = upto[f] + face_area(mesh.corners(f));
    std::vector<SurfaceSample> out;
    if (!(upto.back() > 0)) return out;
    out.reserve(count);
    std::uint32_t f = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const double at = upto.back() * (static_cast<double>(k) + 0.5) / static_cast<double>(count);
        while (f + 1 < mesh.faces.size() && upto[f + 1] <= at) ++f;
        double s = fraction(0.5 + 0.7548776662466927 * static_cast<double>(k));
        double t = fraction(0.5 + 0.5698402909980532 * static_cast<double>(k));
        if (s + t > 1) {
            s = 1 - s;
            t = 1 - t;
        }
        out.push_back({f, {1 - s - t, s, t}});
    }
    return out;
}

}  // namespace dgm::bake
