// SPDX-License-Identifier: GPL-3.0-or-later
// tests/bench/irregular_bench.cpp
// dgm-bench-irregular [--subdivide N] [--write FILE] MESH VERTICES...: the error of irregular meshes of so many
// vertices, to hold grids against.
//
// The mesh is simplified by CGAL's edge collapse with the cost and placement of [Lindstrom, Turk 1998], borders kept by
// both, and normals bounded; its error is measured as that of a map. Then it is fitted again (refit.h), and beside both
// stands the least error of as many triangles (bound.h). One JSON object on standard output:
// {"vertices": of the source, "of": [{"asked", "vertices", "faces", "psnr" in dB, "hausdorff_percent" of the
// diagonal, "refit_psnr", "refit_hausdorff_percent", "bound_psnr"}, ...]},
// the sizes from the largest to the smallest, each simplified from the one before. A size that is not smaller than the
// source, or that cannot be reached, is left out. --subdivide: the source is the mesh after so many steps of Loop's
// subdivision, which --write writes as OBJ. Exit code 1: wrong use, 3: the mesh cannot be used.
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <CGAL/subdivision_method_3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "geometry/metrics/surface_error.h"
#include "geometry/repair/repair.h"
#include "mesh/mesh_reader.h"
#include "reference/bound.h"
#include "reference/refit.h"

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

SurfaceError measured(const TriMesh& source, const dgm::bake::ClosestPointIndex& index, const TriMesh& mesh) {
    dgm::bake::SurfaceErrorOptions options;
    options.source_index = &index;
    return dgm::bake::measure_surface_error(source, mesh, options);
}

TriMesh subdivided(const TriMesh& source, int steps) {
    if (steps == 0) return source;
    Mesh mesh = to_cgal(source);
    CGAL::Subdivision_method_3::Loop_subdivision(mesh, CGAL::parameters::number_of_iterations(steps));
    return from_cgal(std::move(mesh));
}

bool write_obj(const TriMesh& mesh, const std::string& path) {
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (file == nullptr) return false;
    for (const auto& p : mesh.positions) std::fprintf(file, "v %.9g %.9g %.9g\n", p.x, p.y, p.z);
    for (const auto& f : mesh.faces) std::fprintf(file, "f %u %u %u\n", f[0] + 1, f[1] + 1, f[2] + 1);
    return std::fclose(file) == 0;
}

nlohmann::json compare(const TriMesh& source, std::vector<std::size_t> sizes) {
    std::sort(sizes.begin(), sizes.end(), std::greater<>());
    nlohmann::json out = {{"vertices", source.positions.size()}, {"of", nlohmann::json::array()}};
    Mesh mesh = to_cgal(source);
    const dgm::bake::ClosestPointIndex index(source.positions, source.faces);
    for (const std::size_t wanted : sizes) {
        if (wanted >= source.positions.size()) continue;
        sms::edge_collapse(mesh, VertexCount{wanted},
                           CGAL::parameters::get_cost(sms::LindstromTurk_cost<Mesh>())
                               .get_placement(sms::LindstromTurk_placement<Mesh>())
                               .filter(sms::Bounded_normal_change_filter<>()));
        const TriMesh simple = from_cgal(mesh);
        if (simple.positions.size() > wanted) continue;
        const SurfaceError error = measured(source, index, simple);
        const SurfaceError refitted = measured(source, index, dgm::bench::refit(source, index, simple).mesh);
        const double least = dgm::bench::least_rms(source, simple.faces.size());
        out["of"].push_back({{"asked", wanted},
                             {"vertices", simple.positions.size()},
                             {"faces", simple.faces.size()},
                             {"psnr", error.psnr()},
                             {"hausdorff_percent", 100 * error.hausdorff / error.diagonal},
                             {"refit_psnr", refitted.psnr()},
                             {"refit_hausdorff_percent", 100 * refitted.hausdorff / refitted.diagonal},
                             {"bound_psnr", least > 0 ? 20 * std::log10(error.diagonal / least) : 300}});
    }
    return out;
}
}  // namespace

int main(int argc, char** argv) {
    std::vector<std::size_t> sizes;
    int first = 1, steps = 0;
    std::string written;
    for (; first + 1 < argc && argv[first][0] == '-'; first += 2) {
        if (std::strcmp(argv[first], "--subdivide") == 0)
            steps = static_cast<int>(std::strtoul(argv[first + 1], nullptr, 10));
        else if (std::strcmp(argv[first], "--write") == 0)
            written = argv[first + 1];
        else
            break;
    }
    for (int k = first + 1; k < argc; ++k) sizes.push_back(std::strtoul(argv[k], nullptr, 10));
    if (steps > 5 || sizes.empty() || std::find(sizes.begin(), sizes.end(), 0U) != sizes.end()) {
        std::fputs("usage: dgm-bench-irregular [--subdivide 0..5] [--write FILE] MESH VERTICES...\n", stderr);
        return 1;
    }
    try {
        const dgm::bake::RepairedMesh repaired = dgm::bake::repair(dgm::formats::read_mesh(argv[first]).mesh);
        if (repaired.components.size() != 1) throw std::runtime_error("the mesh must have one component");
        const TriMesh source = subdivided(repaired.components[0], steps);
        if (!written.empty() && !write_obj(source, written)) throw std::runtime_error("cannot write " + written);
        std::printf("%s\n", compare(source, sizes).dump().c_str());
    } catch (const std::exception& e) {
        std::fprintf(stderr, "dgm-bench-irregular: %s\n", e.what());
        return 3;
    }
    return 0;
}
