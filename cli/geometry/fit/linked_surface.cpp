// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/linked_surface.cpp
#include "geometry/fit/linked_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/fit/pieces.h"

namespace dgm::bake {
namespace {

constexpr int kMaxSteps = 200;         // of a walk
constexpr int kMaxTurns = 32;          // faces tried around a vertex, each way round
constexpr double kNearer = 1 - 1e-12;  // nearer beyond rounding, or a walk could circle

/// True only if the triangle, which lies within its longer edge l of its first corner, is farther than the root of
/// `squared`: by (a + b)^2 <= 2 (a^2 + b^2), and a margin for rounding.
bool surely_farther(const Vec3d& p, const std::array<Vec3d, 3>& q, double squared) {
    const Vec3d d = p - q[0], e0 = q[1] - q[0], e1 = q[2] - q[0];
    return dot(d, d) > 2.001 * (squared + std::max(dot(e0, e0), dot(e1, e1)));
}

}  // namespace

void LinkedSurface::update_normal(std::size_t face) {
    normals[face] = unit_normal(corners(face));
}

void LinkedSurface::update_normals() {
    normals.resize(faces.size());
    each_in_pieces(faces.size(), [&](std::size_t f) { update_normal(f); });
}

SurfaceHit walk_to_closest(const LinkedSurface& surface, const Vec3d& p, std::uint32_t start, std::uint64_t* looked) {
    SurfaceHit hit{start, 0, {}};
    std::uint64_t faces = 1;
    hit.squared = closest_on_triangle(p, surface.corners(start), hit.b);
    for (int step = 0; step < kMaxSteps; ++step) {
        SurfaceHit best = hit;
        const auto visit = [&](std::uint32_t face) {
            std::array<double, 3> b;
            ++faces;
            const double squared = closest_on_triangle(p, surface.corners(face), b);
            if (squared < best.squared * kNearer) best = {face, squared, b};
        };
        const int zeros = (hit.b[0] <= 0) + (hit.b[1] <= 0) + (hit.b[2] <= 0);
        if (zeros == 0) break;
        if (zeros == 1) {
            const int edge = hit.b[0] <= 0 ? 1 : hit.b[1] <= 0 ? 2 : 0;
            const std::uint32_t across = surface.neighbours[hit.face][edge];
            if (across != kNone) visit(across);
        } else {
            const int corner = hit.b[0] > 0 ? 0 : hit.b[1] > 0 ? 1 : 2;
            const std::uint32_t vertex = surface.faces[hit.face][corner];
            bool all_round = false;
            for (const bool forward : {true, false}) {
                std::uint32_t face = hit.face;
                for (int turn = 0; turn < kMaxTurns && !all_round; ++turn) {
                    const Face& f = surface.faces[face];
                    const int at = f[0] == vertex ? 0 : f[1] == vertex ? 1 : 2;
                    face = surface.neighbours[face][forward ? at : (at + 2) % 3];
                    if (face == kNone) break;
                    all_round = face == hit.face;
                    if (!all_round) visit(face);
                }
            }
        }
        if (best.face == hit.face) break;
        hit = best;
    }
    if (looked != nullptr) *looked += faces;
    return hit;
}

SurfaceHit NearbySearch::from(const Vec3d& p, std::uint32_t start) {
    SurfaceHit best = walk_to_closest(surface_, p, start);
    nearby_.visit(start, [&](std::uint32_t face) {
        const auto q = surface_.corners(face);
        if (surely_farther(p, q, best.squared)) return;
        SurfaceHit hit{face, 0, {}};
        hit.squared = closest_on_triangle(p, q, hit.b);
        if (hit.squared < best.squared) best = hit;
    });
    return best;
}

LinkedSurface link_source(const Disk& disk) {
    LinkedSurface out;
    out.positions.resize(disk.weld_count);
    for (std::size_t v = 0; v < disk.weld.size(); ++v) out.positions[disk.weld[v]] = disk.mesh.positions[v];
    out.faces = disk.mesh.faces;
    out.neighbours.resize(out.faces.size());
    for (std::uint32_t f = 0; f < out.faces.size(); ++f)
        for (std::uint32_t k = 0; k < 3; ++k) {
            out.faces[f][k] = disk.weld[disk.mesh.faces[f][k]];
            const std::uint32_t h = 3 * f + k, across = disk.opposite[h] != kNone ? disk.opposite[h] : disk.mate[h];
            out.neighbours[f][k] = across == kNone ? kNone : across / 3;
        }
    out.update_normals();
    return out;
}

std::vector<Vec3d> normals_at_scale(const LinkedSurface& surface, double area) {
    constexpr int kPasses = 4;
    const std::size_t count = surface.faces.size();
    std::vector<double> weight(count);
    for (std::size_t f = 0; f < count; ++f) weight[f] = std::min(area, face_area(surface.corners(f)));
    std::vector<Vec3d> normals = surface.normals, next(count);
    for (int pass = 0; pass < kPasses; ++pass) {
        for (std::size_t f = 0; f < count; ++f) {
            Vec3d sum = normals[f] * weight[f];
            for (const std::uint32_t g : surface.neighbours[f])
                if (g != kNone) sum += normals[g] * weight[g];
            next[f] = weight[f] >= area ? normals[f] : normalized(sum, normals[f]);
        }
        normals.swap(next);
    }
    return normals;
}

}  // namespace dgm::bake
