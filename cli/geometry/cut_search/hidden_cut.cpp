// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/hidden_cut.cpp
#include "geometry/cut_search/hidden_cut.h"

#include <algorithm>
#include <numbers>

#include "geometry/spatial/exposure.h"
#include "math/portable.h"

namespace dgm::bake {
namespace {

/// Unit normal of the face that a half-edge runs along; zero if it has no area.
Vec3d face_normal(const TriMesh& mesh, std::uint32_t half_edge) {
    return unit_normal(mesh.corners(half_edge / 3));
}

/// The cut along another way, and its cost: infinity if there is none.
double exchange(CutGraph& cut, const CutWay& way) {
    for (const std::uint32_t h : way.half_edges) cut.mark(h, false);
    return cut.connect(way.from, way.to);
}

}  // namespace

std::vector<double> hiding_factors(const TriMesh& mesh, std::span<const std::uint32_t> opposite) {
    constexpr double kLeast = 0.1, kCrease = 0.5, kDeep = std::numbers::pi / 3;
    const std::vector<double> exposure = vertex_exposure(mesh);
    std::vector<double> out(opposite.size(), 1.0);
    for (std::uint32_t h = 0; h < opposite.size(); ++h) {
        const std::uint32_t across = opposite[h];
        if (across == kNone || across < h) continue;
        const std::uint32_t a = origin(mesh.faces, h), b = target(mesh.faces, h);
        const Vec3d n = face_normal(mesh, h), m = face_normal(mesh, across);
        // Signed angle between the faces about the edge, which runs counter-clockwise in the first one.
        const Vec3d along = normalized(mesh.positions[b] - mesh.positions[a], Vec3d{});
        const double turn = math::atan2(dot(cross(n, m), along), dot(n, m));
        const double inward = std::clamp(-turn / kDeep, 0.0, 1.0);
        const double seen = 0.5 * (exposure[a] + exposure[b]);
        out[h] = std::max(kLeast, (kLeast + (1 - kLeast) * seen * seen) * (1 - kCrease * inward));
    }
    return out;
}

std::vector<CutWay> hideable_ways(const CutGraph& cut) {
    constexpr double kWorth = 0.08;  // of the path's cost: less is not worth another map
    const Disk disk = cut.open();
    const std::vector<char> tips = cut.tips();
    const std::vector<BorderPath> paths = disk.paths();
    // A cut without a loop: whatever joins the two parts that it has without a path makes it whole again.
    const bool tree = cut.genus() == 0 && cut.boundary_loop_count() <= 1;
    std::vector<CutWay> out;
    for (std::size_t p = 0; p < paths.size(); ++p) {
        if (paths[p].mate == kNone || paths[p].mate < p || paths[p].is_loop) continue;
        CutWay way{disk.weld[origin(disk.mesh.faces, paths[p].half_edges.front())],
                   disk.weld[target(disk.mesh.faces, paths[p].half_edges.back())], paths[p].half_edges, 0, 0};
        if (!tree && !tips[way.from] && !tips[way.to]) continue;
        for (const std::uint32_t h : way.half_edges) way.cost += cut.edge_cost(h);
        CutGraph other = cut;
        way.saved = way.cost - exchange(other, way);
        if (way.saved > kWorth * way.cost) out.push_back(std::move(way));
    }
    std::stable_sort(out.begin(), out.end(), [](const CutWay& a, const CutWay& b) { return a.saved > b.saved; });
    return out;
}

void hide_way(CutGraph& cut, const CutWay& way) {
    CutGraph other = cut;
    if (exchange(other, way) < way.cost) cut = std::move(other);
}

double seam_exposure(const Disk& disk, const TriMesh& component, int points) {
    const TriMesh& mesh = disk.mesh;
    double total = 0;
    const auto each_seam_edge = [&](auto visit) {
        for (std::uint32_t h = 0; h < disk.mate.size(); ++h) {
            if (disk.mate[h] == kNone || disk.mate[h] < h) continue;
            const Vec3d a = mesh.positions[origin(mesh.faces, h)], b = mesh.positions[target(mesh.faces, h)];
            visit(h, a, b, length(b - a));
        }
    };
    each_seam_edge([&](std::uint32_t, const Vec3d&, const Vec3d&, double along) { total += along; });
    if (!(total > 0)) return 0;
    const ExposureIndex index(component);
    double passed = 0, sum = 0;
    int taken = 0;
    each_seam_edge([&](std::uint32_t h, const Vec3d& a, const Vec3d& b, double along) {
        const double side = disk.same_way(h) ? -1 : 1;
        for (; taken < points && (taken + 0.5) / points * total <= passed + along; ++taken) {
            const double t = std::clamp(((taken + 0.5) / points * total - passed) / along, 0.0, 1.0);
            sum += index.at(a * (1 - t) + b * t,
                            normalized(face_normal(mesh, h) + face_normal(mesh, disk.mate[h]) * side, Vec3d{}));
        }
        passed += along;
    });
    return sum / std::max(taken, 1);
}

}  // namespace dgm::bake
