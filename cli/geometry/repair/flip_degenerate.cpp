// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/flip_degenerate.cpp
// f = (p, q, r) with r on p-q, neighbour g = (q, p, s): flipped to (p, s, r) and (s, q, r).
#include "geometry/repair/flip_degenerate.h"

#include <algorithm>
#include <cmath>

#include "geometry/mesh/flip_edge.h"
#include "geometry/mesh/half_edges.h"
#include "geometry/repair/face_height.h"

namespace dgm::bake {
namespace {

constexpr int kMaxPasses = 16;

void set_corner(TriMesh& mesh, std::uint32_t to, const TriMesh& old, std::uint32_t from) {
    if (!mesh.corner_normals.empty()) mesh.corner_normals[to] = old.corner_normals[from];
    if (!mesh.corner_uvs.empty()) mesh.corner_uvs[to] = old.corner_uvs[from];
    if (!mesh.corner_colours.empty()) mesh.corner_colours[to] = old.corner_colours[from];
}

/// Attributes of r, taken from the neighbour's edge that r lies on.
void blend_corner(TriMesh& mesh, std::uint32_t to, const TriMesh& old, std::uint32_t at_p, std::uint32_t at_q,
                  double t) {
    if (!mesh.corner_normals.empty())
        mesh.corner_normals[to] =
            normalized(old.corner_normals[at_p] * (1 - t) + old.corner_normals[at_q] * t, Vec3d{});
    if (!mesh.corner_uvs.empty()) mesh.corner_uvs[to] = old.corner_uvs[at_p] * (1 - t) + old.corner_uvs[at_q] * t;
    if (!mesh.corner_colours.empty()) mesh.corner_colours[to] = old.corner_colours[t < 0.5 ? at_p : at_q];
}

}  // namespace

std::uint64_t flip_degenerate(TriMesh& mesh) {
    std::uint64_t flips = 0;
    for (int pass = 0; pass < kMaxPasses; ++pass) {
        std::vector<std::uint32_t> thin;
        for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) {
            if (without_height(mesh.corners(f))) thin.push_back(f);
        }
        if (thin.empty()) break;
        const std::vector<std::uint32_t> opposite = opposite_half_edges(mesh.faces);
        const TriMesh old = mesh;
        std::vector<bool> locked(mesh.positions.size(), false);  // vertices whose fans changed in this pass
        std::uint64_t flipped = 0;
        for (std::uint32_t f : thin) {
            std::uint32_t h = 3 * f;
            const auto edge_length = [&](std::uint32_t e) {
                return length(old.positions[target(old.faces, e)] - old.positions[origin(old.faces, e)]);
            };
            for (std::uint32_t e = 3 * f + 1; e < 3 * f + 3; ++e)
                if (edge_length(e) > edge_length(h)) h = e;
            const std::uint32_t o = opposite[h];
            if (o == kNone) continue;
            const std::uint32_t p = origin(old.faces, h), q = target(old.faces, h);
            const std::uint32_t r = target(old.faces, next_half_edge(h)), s = target(old.faces, next_half_edge(o));
            if (locked[p] || locked[q] || locked[r] || locked[s]) continue;
            const Vec3d &P = old.positions[p], &Q = old.positions[q], &R = old.positions[r], &S = old.positions[s];
            const double before = height_share({P, Q, R});
            if (std::min(height_share({P, S, R}), height_share({S, Q, R})) <= 10 * before) continue;
            if (!may_flip(old.faces, opposite, h)) continue;
            const double l = edge_length(h), t = std::clamp(dot(R - P, Q - P) / (l * l), 0.0, 1.0);
            const std::uint32_t g = o / 3, at_q = o, at_p = next_half_edge(o), at_s = previous_half_edge(o);
            mesh.faces[f] = {p, s, r};
            mesh.faces[g] = {s, q, r};
            set_corner(mesh, 3 * f, old, at_p);
            set_corner(mesh, 3 * f + 1, old, at_s);
            blend_corner(mesh, 3 * f + 2, old, at_p, at_q, t);
            set_corner(mesh, 3 * g, old, at_s);
            set_corner(mesh, 3 * g + 1, old, at_q);
            blend_corner(mesh, 3 * g + 2, old, at_p, at_q, t);
            if (!mesh.face_materials.empty()) mesh.face_materials[f] = old.face_materials[g];
            locked[p] = locked[q] = locked[r] = locked[s] = true;
            ++flipped;
        }
        flips += flipped;
        if (flipped == 0) break;
    }
    return flips;
}

}  // namespace dgm::bake
