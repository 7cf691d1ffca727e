// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/source_match.cpp
#include "geometry/layers/source_match.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "geometry/spatial/closest_point.h"

namespace dgm::bake {

Vec3d local_position(const LayerInput& in, const SurfaceSample& at) {
    Vec3d p = position_at(in.chart.disk.mesh, at);
    // source - offset, without forming a large source coordinate first
    for (int k = 0; k < 3; ++k) p[k] = (in.frame.centre[k] - in.stored.offset[k]) + in.frame.diagonal * p[k];
    return p;
}

Vec3d normal_of_face(const TriMesh& mesh, std::uint32_t face) {
    const auto q = mesh.corners(face);
    return normalized(cross(q[1] - q[0], q[2] - q[0]), Vec3d{});
}

Vec3d source_normal(const TriMesh& mesh, const SurfaceSample& at) {
    Vec3d own;
    if (!mesh.corner_normals.empty())
        for (int k = 0; k < 3; ++k) own += mesh.corner_normals[3 * at.face + k] * at.b[k];
    return length(own) > 0.1 ? normalized(own) : normal_of_face(mesh, at.face);
}

Vec2d grid_coordinates(const SampledChart& chart, const MatchedPoint& p) {
    Vec2d out;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t s = p.sample[k];
        const Vec2d at = s < chart.grid_count()
                             ? Vec2d{static_cast<double>(s / chart.n), static_cast<double>(s % chart.n)}
                             : Vec2d{chart.border_uv[s - chart.grid_count()].x * (chart.m - 1),
                                     chart.border_uv[s - chart.grid_count()].y * (chart.n - 1)};
        out = out + at * p.b[k];
    }
    return out;
}

std::vector<MatchedPoint> match_source(const LayerInput& in, const StoredPositions& positions, std::size_t count) {
    constexpr double kMinCosine = 0.3;
    const TriMesh& mesh = in.chart.disk.mesh;
    const std::vector<SurfaceSample> spread = spread_by_area(mesh, count);
    if (spread.empty()) return {};

    TriMesh surface;
    surface.positions = positions.local;
    surface.faces = in.chart.faces();
    const ClosestPointIndex index(surface.positions, surface.faces);
    const double spacing =
        in.frame.diagonal * std::sqrt(surface_area(mesh) / static_cast<double>(in.chart.grid_count()));

    std::vector<MatchedPoint> points(count);
    constexpr std::size_t kChunk = 1024;  // neighbours share a hint
    tbb::parallel_for(std::size_t{0}, (count + kChunk - 1) / kChunk, [&](std::size_t chunk) {
        std::uint32_t hint = ClosestPointIndex::kNoFace, last = kNone;
        Vec3d normal;  // of face `last`: neighbours share it, too
        for (std::size_t k = chunk * kChunk; k < std::min(count, (chunk + 1) * kChunk); ++k) {
            MatchedPoint& p = points[k];
            SurfaceSample from = spread[k];
            const Vec3d position = local_position(in, from);
            if (from.face != last) last = from.face, normal = normal_of_face(mesh, last);
            ClosestPoint hit = index.query(position, hint);
            hint = hit.face;
            if (hit.face != ClosestPointIndex::kNoFace && dot(index.unit_normal(hit.face), normal) <= kMinCosine) {
                const double limit = 2 * hit.distance + 0.25 * spacing;
                const ClosestPoint same =
                    index.query_facing(position, normal, kMinCosine, ClosestPointIndex::kNoFace, limit);
                if (same.distance > limit) from.face = kNone;
                hit = same;
            }
            if (hit.face == ClosestPointIndex::kNoFace) from.face = kNone;
            p.at = from;
            if (from.face == kNone) continue;
            p.face = hit.face;
            p.sample = surface.faces[hit.face];
            p.b = {hit.barycentric[0], hit.barycentric[1], hit.barycentric[2]};
        }
    });
    std::erase_if(points, [](const MatchedPoint& p) { return p.at.face == kNone; });
    return points;
}

}  // namespace dgm::bake
