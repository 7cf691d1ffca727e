// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/surface_values.cpp
//
// [Sander 2001] as in geometry/metrics/map_metrics.cpp: Ss and St are the partial derivatives of the surface along the
// grid, s1 >= s2 their singular values.
#include "render/surface_values.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "math/portable.h"

namespace dgm::render {
namespace {
using model::Face;
using model::Vec2d;
using model::Vec3d;

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

/// On which side a point is, the reconstruction's own normal tells: sources are not always wound alike.
double signed_distance(const bake::ClosestPointIndex& source, const Vec3d& p, const Vec3d& normal) {
    const bake::ClosestPoint nearest = source.query(p);
    if (nearest.face == bake::ClosestPointIndex::kNoFace) return kNothing;
    return dot(p - nearest.point, normal) < 0 ? -nearest.distance : nearest.distance;
}

void keep_larger(double& value, double other) {
    if (std::isnan(value) || std::abs(other) > std::abs(value)) value = other;
}

std::vector<double> distances(const bake::Reconstruction& surface, const bake::ClosestPointIndex& source) {
    const model::TriMesh& mesh = surface.mesh;
    std::vector<double> middle(mesh.faces.size());
    std::vector<Vec3d> normal(mesh.positions.size());
    tbb::parallel_for(std::size_t{0}, middle.size(), [&](std::size_t f) {
        const auto q = mesh.corners(f);
        middle[f] = signed_distance(source, (q[0] + q[1] + q[2]) / 3, cross(q[1] - q[0], q[2] - q[0]));
    });
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const auto q = mesh.corners(f);
        for (const std::uint32_t v : surface.welded_faces[f]) normal[v] += cross(q[1] - q[0], q[2] - q[0]);
    }
    std::vector<double> out(mesh.positions.size(), kNothing);
    std::vector<char> used(out.size(), 0);
    for (const Face& face : surface.welded_faces)
        for (const std::uint32_t v : face) used[v] = 1;
    tbb::parallel_for(std::size_t{0}, out.size(), [&](std::size_t v) {
        if (used[v] != 0) out[v] = signed_distance(source, mesh.positions[v], normal[v]);
    });
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        for (const std::uint32_t v : surface.welded_faces[f]) keep_larger(out[v], middle[f]);
    for (std::size_t v = 0; v < out.size(); ++v) out[v] = out[surface.weld[v]];
    return out;
}

struct Stretch {
    double surface = 0, ratio = 0, dilatation = 0;  // A', A'/A, s1/s2
};

Stretch stretch_of(const std::array<Vec3d, 3>& q, Vec2d p2, Vec2d p3) {
    const double A = 0.5 * cross(p2, p3);
    const Vec3d q2 = q[1] - q[0], q3 = q[2] - q[0];
    Stretch out;
    out.surface = 0.5 * length(cross(q2, q3));
    if (A == 0) return out;
    const Vec3d Ss = (q2 * p3.y - q3 * p2.y) / (2 * A), St = (q3 * p2.x - q2 * p3.x) / (2 * A);
    const double a = dot(Ss, Ss), b = dot(Ss, St), c = dot(St, St);
    out.ratio = out.surface / std::abs(A);
    // s1 s2 is the ratio of areas: a difference of squares would cancel for needles.
    out.dilatation = 0.5 * (a + c + math::hypot(a - c, 2 * b)) / out.ratio;
    return out;
}
}  // namespace

SurfaceValues surface_values(const model::Chart& chart, const bake::Reconstruction& surface,
                             const bake::ClosestPointIndex& source) {
    const model::TriMesh& mesh = surface.mesh;
    SurfaceValues out;
    out.distance = distances(surface, source);
    out.area.assign(mesh.positions.size(), kNothing);
    out.angle = out.area;
    if (mesh.corner_uvs.empty()) return out;
    std::vector<double> weight(mesh.positions.size(), 0), area(weight), angle(weight);
    double all_surface = 0, all_map = 0;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const auto grid = [&](std::size_t k) {
            const Vec2d vu = mesh.corner_uvs[3 * f + k];
            return Vec2d{vu.x * (chart.cols - 1.0), vu.y * (chart.rows - 1.0)};
        };
        const Stretch s = stretch_of(mesh.corners(f), grid(1) - grid(0), grid(2) - grid(0));
        if (!(s.ratio > 0) || !std::isfinite(s.ratio) || !std::isfinite(s.dilatation)) continue;
        all_surface += s.surface;
        all_map += s.surface / s.ratio;
        for (const std::uint32_t v : mesh.faces[f]) {
            weight[v] += s.surface;
            area[v] += s.surface * math::log2(s.ratio);
            angle[v] += s.surface * math::log2(std::max(1.0, s.dilatation));
        }
    }
    const double mean = all_map > 0 ? math::log2(all_surface / all_map) : 0;
    for (std::size_t v = 0; v < weight.size(); ++v)
        if (weight[v] > 0) {
            out.area[v] = area[v] / weight[v] - mean;
            out.angle[v] = angle[v] / weight[v];
        }
    return out;
}

std::vector<double> source_distances(const model::TriMesh& source, const model::TriMesh& map) {
    const bake::ClosestPointIndex index(map.positions, map.faces);
    const auto distance = [&](const Vec3d& p) {
        const bake::ClosestPoint nearest = index.query(p);
        if (nearest.face == bake::ClosestPointIndex::kNoFace) return kNothing;
        const auto q = map.corners(nearest.face);
        const bool outside = dot(p - nearest.point, cross(q[1] - q[0], q[2] - q[0])) > 0;
        return outside ? -nearest.distance : nearest.distance;
    };
    std::vector<double> out(source.positions.size(), kNothing), middle(source.faces.size(), kNothing);
    std::vector<char> used(out.size(), 0);
    // A face of a coarse mesh is large against the grid's: one point would not tell.
    constexpr double kPoints = 200'000;
    const int side = std::clamp(static_cast<int>(std::sqrt(2 * kPoints / (source.faces.size() + 1.0))), 1, 16);
    const auto good = [&](const Face& f) {
        return std::all_of(f.begin(), f.end(), [&](std::uint32_t v) { return v < out.size(); });
    };
    for (const Face& face : source.faces)
        if (good(face))
            for (const std::uint32_t v : face) used[v] = 1;
    tbb::parallel_for(std::size_t{0}, out.size(), [&](std::size_t v) {
        if (used[v] != 0) out[v] = distance(source.positions[v]);
    });
    tbb::parallel_for(std::size_t{0}, middle.size(), [&](std::size_t f) {
        if (!good(source.faces[f])) return;
        const auto q = source.corners(f);
        for (int a = 0; a < side; ++a)
            for (int b = 0; a + b < side; ++b) {
                const double s = (a + 1.0 / 3) / side, t = (b + 1.0 / 3) / side;
                keep_larger(middle[f], distance(q[0] + s * (q[1] - q[0]) + t * (q[2] - q[0])));
            }
    });
    for (std::size_t f = 0; f < middle.size(); ++f)
        if (good(source.faces[f]))
            for (const std::uint32_t v : source.faces[f]) keep_larger(out[v], middle[f]);
    return out;
}

}  // namespace dgm::render
