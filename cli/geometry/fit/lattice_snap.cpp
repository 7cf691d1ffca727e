// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/lattice_snap.cpp
#include "geometry/fit/lattice_snap.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace dgm::bake {
namespace {

constexpr double kTightSteps = 8;  // of a lattice: faces less high than so many are watched while they are rounded
constexpr double kUpright = 0.2;   // cosine to the source below, under which such a face counts as spoilt
constexpr double kKept = 0.5;      // and to its own normal before

}  // namespace

void snap_to_lattice(const Lattice& lattice, const NormalEquations& equations, std::span<const Freedom> freedom,
                     std::size_t grid_count, const LinkedSurface& source, WeldedGrid& welded, Matches& matches,
                     InvertedFaces& inverted) {
    LinkedSurface& grid = welded.surface;
    const std::vector<Vec3d> start = grid.positions, normals = grid.normals;
    std::vector<char> on_lattice(start.size()), tight(start.size(), 0);
    for (std::size_t c = 0; c < on_lattice.size(); ++c) on_lattice[c] = welded.sample_of[c] < grid_count;
    for (std::uint32_t f = 0; f < grid.faces.size(); ++f) {
        const auto q = grid.corners(f);
        if (2 * face_area(q) < kTightSteps * lattice.step * std::sqrt(longest_edge_squared(q)))
            for (const std::uint32_t c : grid.faces[f]) tight[c] = 1;
    }
    const WeldedGrid::Rings rings = welded.rings();
    const auto spoilt = [&](std::uint32_t c) {
        int count = 0;
        for (std::uint32_t k = rings.first[c]; k < rings.first[c + 1]; ++k) {
            const auto q = grid.corners(rings.faces[k]);
            const Vec3d n = cross(q[1] - q[0], q[2] - q[0]);
            const Vec3d below = source.normals[matches.middles[rings.faces[k]].hit.face];
            count += !(dot(n, below) > kUpright * length(n));
            count += !(dot(n, normals[rings.faces[k]]) > kKept * length(n));
        }
        return count;
    };
    equations.snap(grid.positions, lattice, freedom, on_lattice, tight, spoilt);
    grid.update_normals();
    const bool with_edges = !matches.edges.empty();
    matches.update(with_edges);
    bool moved = false;
    // Faces as high as a step or two: the corner that stands them up best moves, by two steps at most.
    for (const std::uint32_t f : inverted.faces())
        for (const std::uint32_t c : grid.faces[f]) {
            if (!on_lattice[c] || welded.on_border[c]) continue;
            const auto least = [&] {
                double out = 1;
                for (std::uint32_t k = rings.first[c]; k < rings.first[c + 1]; ++k) {
                    const Vec3d n = unit_normal(grid.corners(rings.faces[k]));
                    out = std::min(out, dot(n, source.normals[matches.middles[rings.faces[k]].hit.face]));
                }
                return out;
            };
            const Vec3d old = grid.positions[c];
            Vec3d best = old;
            double most = least();
            for (int k = 0; k < 125; ++k) {
                const Vec3d by{k % 5 - 2.0, k / 5 % 5 - 2.0, k / 25 - 2.0};
                grid.positions[c] = lattice.nearest(old + by * lattice.step);
                if (const double now = least(); now > most) {
                    most = now;
                    best = grid.positions[c];
                }
            }
            grid.positions[c] = best;
            moved = moved || best != old;
        }
    if (!moved) return;
    grid.update_normals();
    matches.update(with_edges);
}

}  // namespace dgm::bake
