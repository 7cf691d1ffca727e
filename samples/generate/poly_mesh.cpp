// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/poly_mesh.cpp
#include "poly_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace dgm::samples {
namespace {
using model::Vec2d;
using model::Vec3d;

double rounded(double x) {
    const double r = std::round(x * 1e5) / 1e5;
    return r == 0 ? 0 : r;  // no minus zero in the files
}

// Twice the area times the normal; the cross product of the diagonals for a quad.
Vec3d area_vector(const PolyMesh& mesh, const Polygon& p) {
    const Vec3d &a = mesh.positions[p.vertex[0]], &b = mesh.positions[p.vertex[1]], &c = mesh.positions[p.vertex[2]];
    return p.n == 3 ? cross(b - a, c - a) : cross(c - a, mesh.positions[p.vertex[3]] - b);
}
}  // namespace

void add_cell(PolyMesh& mesh, const Polygon& quad, int i, int j, int cells) {
    if ((i != 0 && i != cells - 1) || (j != 0 && j != cells - 1)) {
        mesh.polygons.push_back(quad);
        return;
    }
    const std::size_t start = (i == 0) == (j == 0) ? 0 : 1;
    for (const std::size_t k : {start + 1, start + 2}) {
        Polygon p = quad;
        p.n = 3;
        p.vertex = {quad.vertex[start], quad.vertex[k], quad.vertex[(k + 1) % 4], 0};
        p.uv = {quad.uv[start], quad.uv[k], quad.uv[(k + 1) % 4], 0};
        mesh.polygons.push_back(p);
    }
}

void quantise(PolyMesh& mesh) {
    for (Vec3d& p : mesh.positions) p = {rounded(p.x), rounded(p.y), rounded(p.z)};
    for (Vec2d& t : mesh.uvs) t = {rounded(t.x), rounded(t.y)};
}

void orient_outward(PolyMesh& mesh) {
    double volume = 0;
    for (const Polygon& p : mesh.polygons)
        for (int k = 2; k < p.n; ++k)
            volume += dot(mesh.positions[p.vertex[0]], cross(mesh.positions[p.vertex[static_cast<std::size_t>(k) - 1]],
                                                             mesh.positions[p.vertex[static_cast<std::size_t>(k)]]));
    if (volume >= 0) return;
    for (Polygon& p : mesh.polygons) {
        std::reverse(p.vertex.begin(), p.vertex.begin() + p.n);
        std::reverse(p.uv.begin(), p.uv.begin() + p.n);
    }
}

std::vector<Vec3d> corner_normals(const PolyMesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, Vec3d> sums;  // by vertex and group
    for (const Polygon& p : mesh.polygons)
        for (int k = 0; k < p.n; ++k) sums[{p.vertex[static_cast<std::size_t>(k)], p.group}] += area_vector(mesh, p);
    std::vector<Vec3d> out(mesh.polygons.size() * 4);
    for (std::size_t f = 0; f < mesh.polygons.size(); ++f)
        for (std::size_t k = 0; k < static_cast<std::size_t>(mesh.polygons[f].n); ++k)
            out[4 * f + k] = normalized(sums[{mesh.polygons[f].vertex[k], mesh.polygons[f].group}]);
    return out;
}

}  // namespace dgm::samples
