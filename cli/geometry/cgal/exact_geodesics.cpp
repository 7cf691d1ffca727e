// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cgal/exact_geodesics.cpp
#include "geometry/cgal/exact_geodesics.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_shortest_path.h>

#include <algorithm>
#include <limits>

#include "model/codes.h"

namespace dgm::bake {
namespace {

using model::Vec3d;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Traits = CGAL::Surface_mesh_shortest_path_traits<Kernel, Mesh>;
using ShortestPath = CGAL::Surface_mesh_shortest_path<Traits>;

/// A face none of whose points is within `radius` of `centre` is no part of such a path.
bool in_reach(const std::array<Vec3d, 3>& q, const Vec3d& centre, double radius) {
    const double edge = std::max({length(q[1] - q[0]), length(q[2] - q[1]), length(q[0] - q[2])});
    return length(q[0] - centre) <= radius + edge;
}

}  // namespace

std::vector<double> exact_geodesics(std::span<const Vec3d> positions, std::span<const model::Face> faces,
                                    std::uint32_t source, double radius) {
    const auto fail = [](const char* why) { throw model::Error(model::codes::kInternal, why); };
    if (source >= positions.size()) fail("geodesics from a vertex that is not there");
    std::vector<double> out(positions.size(), std::numeric_limits<double>::infinity());
    out[source] = 0;
    Mesh mesh;
    std::vector<Mesh::Vertex_index> vertex(positions.size());
    const auto vertex_of = [&](std::uint32_t v) {
        if (!vertex[v].is_valid()) vertex[v] = mesh.add_vertex({positions[v].x, positions[v].y, positions[v].z});
        return vertex[v];
    };
    for (const model::Face& f : faces) {
        for (const std::uint32_t v : f)
            if (v >= positions.size()) fail("a face of the geodesics' mesh names a vertex that is not there");
        const std::array q{positions[f[0]], positions[f[1]], positions[f[2]]};
        const Vec3d area = cross(q[1] - q[0], q[2] - q[0]);
        if (!(dot(area, area) > 0) || !in_reach(q, positions[source], radius)) continue;
        mesh.add_face(vertex_of(f[0]), vertex_of(f[1]), vertex_of(f[2]));  // null where an edge would get a third face
    }
    if (!vertex[source].is_valid() || mesh.is_isolated(vertex[source])) return out;
    try {
        ShortestPath paths(mesh);
        paths.add_source_point(vertex[source]);
        paths.build_sequence_tree();
        for (std::uint32_t v = 0; v < positions.size(); ++v) {
            if (!vertex[v].is_valid() || mesh.is_isolated(vertex[v])) continue;
            const double distance = paths.shortest_distance_to_source_points(vertex[v]).first;
            if (distance >= 0 && distance <= radius) out[v] = distance;
        }
    } catch (const std::exception& error) { fail(error.what()); }
    return out;
}

}  // namespace dgm::bake
