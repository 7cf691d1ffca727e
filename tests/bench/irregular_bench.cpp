// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/irregular_bench.cpp
// dgm-bench-irregular MESH VERTICES...: the error of irregular meshes of so many vertices, to hold grids against.
//
// The mesh is simplified by CGAL's edge collapse with the cost and placement of [Lindstrom, Turk 1998], borders kept by
// both, and normals bounded; its error is measured as that of a map. One JSON object on standard output:
// {"vertices": of the source, "of": [{"asked", "vertices", "faces", "psnr" in dB, "hausdorff_percent" of the
// diagonal}, ...]},
// the sizes from the largest to the smallest, each simplified from the one before. A size that is not smaller than the
// source, or that cannot be reached, is left out. Exit code 1: wrong use, 3: the mesh cannot be used.
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "geometry/metrics/surface_error.h"
#include "geometry/repair/repair.h"
#include "mesh/mesh_reader.h"

namespace {
namespace sms = CGAL::Surface_mesh_simplification;
using dgm::bake::SurfaceError;
using dgm::model::TriMesh;
using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

Mesh to_cgal(const TriMesh& from) {
    Mesh out;
    std::vector<Mesh::Vertex_index> vertices;
    vertices.reserve(from.positions.size());
    for (const auto& p : from.positions) vertices.push_back(out.add_vertex({p.x, p.y, p.z}));
    for (const auto& f : from.faces) out.add_face(vertices[f[0]], vertices[f[1]], vertices[f[2]]);
    return out;
}

TriMesh from_cgal(Mesh mesh) {
    mesh.collect_garbage();
    TriMesh out;
    for (const auto v : mesh.vertices())
        out.positions.push_back({mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z()});
    for (const auto f : mesh.faces()) {
        std::array<std::uint32_t, 3> corners{};
        std::size_t k = 0;
        for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) corners[k++] = static_cast<std::uint32_t>(v);
        out.faces.push_back(corners);
    }
    return out;
}

/// Ends a simplification at a number of vertices.
struct VertexCount {
    std::size_t wanted;
    template <class Cost, class Profile>
    bool operator()(const Cost&, const Profile& profile, std::size_t, std::size_t) const {
        return profile.surface_mesh().number_of_vertices() <= wanted;
    }
};

nlohmann::json compare(const TriMesh& source, std::vector<std::size_t> sizes) {
    std::sort(sizes.begin(), sizes.end(), std::greater<>());
    nlohmann::json out = {{"vertices", source.positions.size()}, {"of", nlohmann::json::array()}};
    Mesh mesh = to_cgal(source);
    for (const std::size_t wanted : sizes) {
        if (wanted >= source.positions.size()) continue;
        sms::edge_collapse(mesh, VertexCount{wanted},
                           CGAL::parameters::get_cost(sms::LindstromTurk_cost<Mesh>())
                               .get_placement(sms::LindstromTurk_placement<Mesh>())
                               .filter(sms::Bounded_normal_change_filter<>()));
        const TriMesh simple = from_cgal(mesh);
        if (simple.positions.size() > wanted) continue;
        const SurfaceError error = dgm::bake::measure_surface_error(source, simple);
        out["of"].push_back({{"asked", wanted},
                             {"vertices", simple.positions.size()},
                             {"faces", simple.faces.size()},
                             {"psnr", error.psnr()},
                             {"hausdorff_percent", 100 * error.hausdorff / error.diagonal}});
    }
    return out;
}
}  // namespace

int main(int argc, char** argv) {
    std::vector<std::size_t> sizes;
    for (int k = 2; k < argc; ++k) sizes.push_back(std::strtoul(argv[k], nullptr, 10));
    if (sizes.empty() || std::find(sizes.begin(), sizes.end(), 0U) != sizes.end()) {
        std::fputs("usage: dgm-bench-irregular MESH VERTICES...\n", stderr);
        return 1;
    }
    try {
        const dgm::bake::RepairedMesh repaired = dgm::bake::repair(dgm::formats::read_mesh(argv[1]).mesh);
        if (repaired.components.size() != 1) throw std::runtime_error("the mesh must have one component");
        std::printf("%s\n", compare(repaired.components[0], sizes).dump().c_str());
    } catch (const std::exception& e) {
        std::fprintf(stderr, "dgm-bench-irregular: %s\n", e.what());
        return 3;
    }
    return 0;
}
