// SPDX-License-Identifier: GPL-3.0-or-later
// tests/reference/cgal_reference.cpp
#include "reference/cgal_reference.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_parameterization/ARAP_parameterizer_3.h>
#include <CGAL/Surface_mesh_parameterization/LSCM_parameterizer_3.h>

namespace dgm::bake {
namespace {
namespace smp = CGAL::Surface_mesh_parameterization;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Vertex = Mesh::Vertex_index;

template <typename Method>
std::optional<std::vector<Vec2d>> run(const DiskView& disk, Method method) {
    Mesh mesh;
    for (const Vec3d& p : disk.positions) mesh.add_vertex(Kernel::Point_3(p.x, p.y, p.z));
    for (const Face& f : disk.faces)
        if (mesh.add_face(Vertex(f[0]), Vertex(f[1]), Vertex(f[2])) == Mesh::null_face()) return std::nullopt;
    Mesh::Halfedge_index border;
    for (const Mesh::Halfedge_index h : mesh.halfedges())
        if (mesh.is_border(h)) border = h;
    if (!border.is_valid()) return std::nullopt;
    auto uv = mesh.add_property_map<Vertex, Kernel::Point_2>("v:uv", Kernel::Point_2(0, 0)).first;
    auto done = mesh.add_property_map<Vertex, bool>("v:done", false).first;
    auto index = mesh.add_property_map<Vertex, int>("v:index", 0).first;
    for (const Vertex v : mesh.vertices()) index[v] = static_cast<int>(v.idx());
    if (method.parameterize(mesh, border, uv, index, done) != smp::OK) return std::nullopt;
    std::vector<Vec2d> out;
    for (const Vertex v : mesh.vertices()) out.push_back({uv[v].x(), uv[v].y()});
    return out;
}
}  // namespace

std::optional<std::vector<Vec2d>> cgal_default_arap(const DiskView& disk) {
    return run(disk, smp::ARAP_parameterizer_3<Mesh>());
}

std::optional<std::vector<Vec2d>> cgal_default_lscm(const DiskView& disk) {
    return run(disk, smp::LSCM_parameterizer_3<Mesh>());
}

}  // namespace dgm::bake
