// SPDX-License-Identifier: GPL-3.0-or-later
// tests/reference/bound.cpp
#include "reference/bound.h"

#include <cmath>
#include <cstdint>
#include <vector>

namespace dgm::bench {
namespace {
using model::Face;
using model::Vec3d;

std::vector<Vec3d> vertex_normals(const model::TriMesh& mesh) {
    std::vector<Vec3d> out(mesh.positions.size());
    for (const Face& f : mesh.faces) {
        const Vec3d& p = mesh.positions[f[0]];
        const Vec3d area = cross(mesh.positions[f[1]] - p, mesh.positions[f[2]] - p);
        for (const std::uint32_t v : f) out[v] += area;
    }
    for (Vec3d& n : out) n = normalized(n, Vec3d{0, 0, 1});
    return out;
}

/// Determinant of the symmetric shape operator that takes the edges of a face to the changes of the normals along them.
double gaussian_curvature(const Vec3d& a, const Vec3d& b, const Vec3d& da, const Vec3d& db) {
    const Vec3d x = normalized(a, Vec3d{1, 0, 0}), y = cross(normalized(cross(a, b), Vec3d{0, 0, 1}), x);
    const double ax = dot(a, x), bx = dot(b, x), by = dot(b, y);
    // S (ax, 0) = da, S (bx, by) = db in these axes.
    const double xx = dot(da, x) / ax, yx = dot(da, y) / ax;
    const double xy = (dot(db, x) - bx * xx) / by, yy = (dot(db, y) - bx * yx) / by, mixed = 0.5 * (xy + yx);
    return xx * yy - mixed * mixed;
}
}  // namespace

double least_rms(const model::TriMesh& mesh, std::size_t triangles) {
    const std::vector<Vec3d> normals = vertex_normals(mesh);
    double area = 0, sum = 0;
    for (const Face& f : mesh.faces) {
        const Vec3d &p = mesh.positions[f[0]], a = mesh.positions[f[1]] - p, b = mesh.positions[f[2]] - p;
        const double own = 0.5 * length(cross(a, b));
        if (!(own > 0)) continue;
        const double k = gaussian_curvature(a, b, normals[f[1]] - normals[f[0]], normals[f[2]] - normals[f[0]]);
        area += own;
        sum += own * std::cbrt(k > 0 ? k / 180 : -k / 90);
    }
    return std::sqrt(sum * sum * sum / area) / static_cast<double>(triangles);
}

}  // namespace dgm::bench
