// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/fit_to_square.cpp
#include "geometry/chart/fit_to_square.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/mesh/infinity.h"
#include "geometry/metrics/map_metrics.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {

// A comb of 2,500 long teeth has a border of 315,000 cells on a grid of 65 x 65, and on straight edges that are divided
// no sample is nearer to the surface. Ordinary charts need a tenth of this.
constexpr double kAddedPerSample = 4;

std::vector<Vec2d> convex_hull(std::vector<Vec2d> points) {
    std::sort(points.begin(), points.end(), [](Vec2d a, Vec2d b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
    std::vector<Vec2d> hull;
    for (int half = 0; half < 2; ++half) {
        const std::size_t base = hull.size();
        for (const Vec2d& p : points) {
            while (hull.size() >= base + 2 && orient2d(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
            hull.push_back(p);
        }
        hull.pop_back();
        std::reverse(points.begin(), points.end());
    }
    return hull;
}

}  // namespace

void fit_to_square(std::vector<Vec2d>& uv, std::span<const std::uint32_t> border, std::uint32_t m, std::uint32_t n,
                   Box box) {
    constexpr int kAngles = 90;
    std::vector<Vec2d> points;
    for (std::uint32_t v : border) points.push_back(uv[v]);
    const std::vector<Vec2d> hull = convex_hull(points);
    Vec2d axis{1, 0};
    double least = kInfinity;
    const auto extent = [&](Vec2d d) {
        double lo = kInfinity, hi = -kInfinity;
        for (const Vec2d& p : hull) {
            lo = std::min(lo, dot(p, d));
            hi = std::max(hi, dot(p, d));
        }
        return std::pair(lo, hi);
    };
    const auto consider = [&](Vec2d d) {
        const auto [a, b] = extent(d);
        const auto [c, f] = extent({-d.y, d.x});
        const double along = b - a, across = f - c;
        // The longer side along the axis with more samples.
        const bool turn = (along >= across) != (m >= n);
        const double du = (turn ? across : along) / (m - 1.0), dv = (turn ? along : across) / (n - 1.0);
        const double size = box == Box::kLeastArea ? du * dv : du * du + dv * dv;
        if (!(size < least * (1 - 1e-12))) return;
        least = size;
        axis = turn ? Vec2d{-d.y, d.x} : d;
    };
    for (std::size_t k = 0; k < hull.size(); ++k) {
        const Vec2d e = hull[(k + 1) % hull.size()] - hull[k];
        if (const double l = length(e); l > 0) consider(e * (1 / l));
    }
    // Between the directions of the hull's edges the area has no minimum, but the sum of squares may.
    for (int k = 0; k < kAngles && box == Box::kLeastSquares; ++k) {
        const double angle = 0.5 * M_PI * k / kAngles;
        consider({math::cos(angle), math::sin(angle)});
    }
    const Vec2d across{-axis.y, axis.x};
    const auto [u0, u1] = extent(axis);
    const auto [v0, v1] = extent(across);
    for (Vec2d& p : uv)
        p = {std::clamp((dot(p, axis) - u0) / (u1 - u0), 0.0, 1.0),
             std::clamp((dot(p, across) - v0) / (v1 - v0), 0.0, 1.0)};
}

NewVertices split_border(Disk& disk, std::vector<Vec2d>& uv, std::uint32_t h, double t) {
    const auto between = [&](std::uint32_t e, double s) {
        return uv[origin(disk.mesh.faces, e)] * (1 - s) + uv[target(disk.mesh.faces, e)] * s;
    };
    const std::uint32_t mate = disk.mate[h];
    const Vec2d here = between(h, t), there = mate == kNone ? Vec2d{} : between(mate, disk.same_way(h) ? t : 1 - t);
    const NewVertices added = disk.split(h, t);
    uv.push_back(here);
    if (added.twin != kNone) uv.push_back(there);
    return added;
}

void divide_border(Disk& disk, std::vector<Vec2d>& uv, double rows, double cols) {
    constexpr double kMaxPieces = 64;
    const auto cells = [&](std::uint32_t h) {
        const Vec2d d = uv[target(disk.mesh.faces, h)] - uv[origin(disk.mesh.faces, h)];
        return math::hypot(d.x * rows, d.y * cols);
    };
    const auto longer_side = [&](std::uint32_t h) {
        return std::max(cells(h), disk.mate[h] == kNone ? 0.0 : cells(disk.mate[h]));
    };
    double all = 0;
    for (std::uint32_t h = 0; h < disk.opposite.size(); ++h)
        if (disk.opposite[h] == kNone) all += longer_side(h);
    const double most = kAddedPerSample * (rows + 1) * (cols + 1), per_cell = all > most ? most / all : 1;
    for (std::uint32_t h = 0; h < disk.opposite.size(); ++h) {  // grows; new border edges are short by construction
        if (disk.opposite[h] != kNone) continue;
        const double wanted = std::ceil(per_cell * longer_side(h) - 1e-9);
        std::uint32_t at = h;
        for (auto pieces = static_cast<int>(std::min(wanted, kMaxPieces)); pieces > 1; --pieces) {
            // The last piece comes off, `at` keeps the rest.
            at = split_border(disk, uv, at, (pieces - 1.0) / pieces).first;
        }
    }
}

}  // namespace dgm::bake
