// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cgal/constrained_triangulation.cpp
#include "geometry/cgal/constrained_triangulation.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>

#include "model/codes.h"

namespace dgm::bake {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
using FaceBase =
    CGAL::Triangulation_face_base_with_info_2<int, Kernel, CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using Cdt =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>,
                                               CGAL::Exact_predicates_tag>;

/// Number of constraints between each face and the outside.
void mark_depth(Cdt& cdt) {
    for (auto f : cdt.all_face_handles()) f->info() = -1;
    std::vector<Cdt::Face_handle> here{cdt.infinite_face()}, next;
    for (int depth = 0; !here.empty(); ++depth, here.swap(next), next.clear()) {
        while (!here.empty()) {
            const Cdt::Face_handle f = here.back();
            here.pop_back();
            if (f->info() != -1) continue;
            f->info() = depth;
            for (int k = 0; k < 3; ++k)
                if (f->neighbor(k)->info() == -1) (cdt.is_constrained({f, k}) ? next : here).push_back(f->neighbor(k));
        }
    }
}

}  // namespace

std::vector<model::Face> constrained_triangulation(
    std::span<const model::Vec2d> points, std::span<const std::pair<std::uint32_t, std::uint32_t>> constraints) {
    Cdt cdt;
    std::vector<Cdt::Vertex_handle> vertices;
    for (std::uint32_t k = 0; k < points.size(); ++k) {
        const Cdt::Vertex_handle v = cdt.insert(Kernel::Point_2(points[k].x, points[k].y),
                                                vertices.empty() ? Cdt::Face_handle() : vertices.back()->face());
        v->info() = k;
        vertices.push_back(v);
    }
    for (const auto& [a, b] : constraints) {
        if (vertices[a] == vertices[b])
            throw model::Error(model::codes::kMapInvalid, "two border points of the chart coincide");
        cdt.insert_constraint(vertices[a], vertices[b]);
    }
    if (cdt.number_of_vertices() != points.size())
        throw model::Error(model::codes::kMapInvalid, "the chart's border touches itself or the lattice");
    mark_depth(cdt);
    std::vector<model::Face> faces;
    for (auto f : cdt.finite_face_handles()) {
        if (f->info() % 2 == 0) continue;
        model::Face face{f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()};
        std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
        faces.push_back(face);
    }
    std::sort(faces.begin(), faces.end());  // not in the order of the triangulation's memory
    return faces;
}

}  // namespace dgm::bake
