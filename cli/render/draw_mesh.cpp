// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/draw_mesh.cpp
//
// [Rossignac and Borrel 1993] Multi-resolution 3D approximations for rendering complex scenes.
#include "render/draw_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>
#include <utility>

#include "render/normals.h"

namespace dgm::render {
namespace {
using model::Face;
using model::TriMesh;
using model::Vec3d;

constexpr double kCreaseDegrees = 50;

/// Cubes that divide a box.
struct Lattice {
    using Cell = std::array<std::int32_t, 3>;
    Vec3d low;
    double side;
    [[nodiscard]] Cell operator()(const Vec3d& p) const {
        Cell out{};
        for (int k = 0; k < 3; ++k)
            out[static_cast<std::size_t>(k)] = static_cast<std::int32_t>((p[k] - low[k]) / side);
        return out;
    }
};

struct Corner {
    std::uint32_t vertex;
    Vec3d position, normal;
    Lattice::Cell cell{};
};

std::vector<Corner> corners_of(const TriMesh& mesh) {
    const std::vector<Vec3d> normals = mesh.corner_normals.size() == 3 * mesh.faces.size()
                                           ? mesh.corner_normals
                                           : render::smooth_corner_normals(mesh, kCreaseDegrees);
    std::vector<Corner> out;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const Face& face = mesh.faces[f];
        if (std::any_of(face.begin(), face.end(),
                        [&](std::uint32_t v) { return v >= mesh.positions.size() || !is_finite(mesh.positions[v]); }))
            continue;
        const auto q = mesh.corners(f);
        const Vec3d flat = normalized(cross(q[1] - q[0], q[2] - q[0]));
        for (std::size_t k = 0; k < 3; ++k) out.push_back({face[k], q[k], normalized(normals[3 * f + k], flat), {}});
    }
    return out;
}

/// Which vertex of the result each corner is, by a key of its own; keys are numbered as they come.
template <class KeyOf>
DrawMesh joined(const std::vector<Corner>& corners, const KeyOf& key_of) {
    std::map<decltype(key_of(corners[0])), std::uint32_t> numbers;
    DrawMesh out;
    std::vector<double> counts;
    Face face{};
    for (std::size_t c = 0; c < corners.size(); ++c) {
        const auto [place, is_new] =
            numbers.try_emplace(key_of(corners[c]), static_cast<std::uint32_t>(out.positions.size()));
        if (is_new) out.positions.emplace_back(), out.normals.emplace_back(), counts.push_back(0);
        const std::uint32_t v = face[c % 3] = place->second;
        out.positions[v] += corners[c].position;
        out.normals[v] += corners[c].normal;
        counts[v] += 1;
        out.origins.push_back({v, corners[c].vertex});
        if (c % 3 == 2 && face[0] != face[1] && face[1] != face[2] && face[2] != face[0]) out.faces.push_back(face);
    }
    for (std::size_t v = 0; v < counts.size(); ++v) {
        out.positions[v] = out.positions[v] / counts[v];
        out.normals[v] = normalized(out.normals[v]);
    }
    return out;
}

int side_of(const Vec3d& n) {
    const std::array<double, 3> size{std::abs(n.x), std::abs(n.y), std::abs(n.z)};
    const int axis = static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
    return 2 * axis + (n[axis] < 0 ? 1 : 0);
}

}  // namespace

DrawMesh draw_mesh(const TriMesh& mesh, std::size_t most) {
    const std::vector<Corner> corners = corners_of(mesh);
    if (corners.empty()) return {};
    constexpr double kSteps = 64;  // normals that differ by less than about a degree count as one
    DrawMesh out = joined(corners, [](const Corner& c) {
        return std::tuple(c.vertex, std::lround(kSteps * c.normal.x), std::lround(kSteps * c.normal.y),
                          std::lround(kSteps * c.normal.z));
    });
    if (out.positions.size() <= most && out.faces.size() <= 3 * most) return out;
    Vec3d low = corners[0].position, high = low;
    for (const Corner& c : corners)
        for (int k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], c.position[k]);
            high[k] = std::max(high[k], c.position[k]);
        }
    const double extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z, 1e-300});
    // A surface takes cells by the square of their number a side.
    for (double cells = 256;;
         cells *= std::min(0.8, 0.95 * std::sqrt(static_cast<double>(most) / out.positions.size()))) {
        const Lattice lattice{low, extent / cells};
        // All sides of a cell have one place, so that nothing gapes between them.
        std::map<Lattice::Cell, std::pair<Vec3d, double>> places;
        for (const Corner& c : corners) {
            auto& [sum, count] = places[lattice(c.position)];
            sum += c.position;
            count += 1;
        }
        std::vector<Corner> moved = corners;
        for (Corner& c : moved) {
            const Lattice::Cell cell = lattice(c.position);
            const auto& [sum, count] = places[cell];
            c.position = sum / count;
            c.cell = cell;
        }
        out = joined(moved, [](const Corner& c) { return std::pair(c.cell, side_of(c.normal)); });
        if ((out.positions.size() <= most && out.faces.size() <= 3 * most) || cells < 2) break;
    }
    std::sort(out.faces.begin(), out.faces.end());
    out.faces.erase(std::unique(out.faces.begin(), out.faces.end()), out.faces.end());
    out.simplified = true;
    return out;
}

}  // namespace dgm::render
