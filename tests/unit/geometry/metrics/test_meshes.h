// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/metrics/test_meshes.h
// Small surfaces whose counts, areas and distances are known in closed form.
#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>

#include "model/tri_mesh.h"

namespace dgm::test {

/// Cell (i, j) of an a x b grid of vertices, as two faces. `wrap_i`, `wrap_j` join the last row or column to the first.
inline std::vector<model::Face> grid_faces(std::uint32_t a, std::uint32_t b, bool wrap_i = false, bool wrap_j = false) {
    std::vector<model::Face> faces;
    for (std::uint32_t i = 0; i < (wrap_i ? a : a - 1); ++i)
        for (std::uint32_t j = 0; j < (wrap_j ? b : b - 1); ++j) {
            const std::uint32_t p = i * b + j, q = (i + 1) % a * b + j;
            const std::uint32_t r = (i + 1) % a * b + (j + 1) % b, s = i * b + (j + 1) % b;
            faces.push_back({p, q, r});
            faces.push_back({p, r, s});
        }
    return faces;
}

/// Square [0, side]^2 at height z, as cells x cells quads.
inline model::TriMesh square(double side, double z, std::uint32_t cells) {
    model::TriMesh mesh;
    for (std::uint32_t i = 0; i <= cells; ++i)
        for (std::uint32_t j = 0; j <= cells; ++j) mesh.positions.push_back({side * i / cells, side * j / cells, z});
    mesh.faces = grid_faces(cells + 1, cells + 1);
    return mesh;
}

/// Closed sphere about the origin: `bands` of latitude, 2 * bands of longitude, poles shared.
inline model::TriMesh sphere(double radius, std::uint32_t bands) {
    model::TriMesh mesh;
    const std::uint32_t around = 2 * bands;
    for (std::uint32_t i = 1; i < bands; ++i)
        for (std::uint32_t j = 0; j < around; ++j) {
            const double theta = std::numbers::pi * i / bands, phi = 2 * std::numbers::pi * j / around;
            mesh.positions.push_back({radius * std::sin(theta) * std::cos(phi),
                                      radius * std::sin(theta) * std::sin(phi), radius * std::cos(theta)});
        }
    mesh.faces = grid_faces(bands - 1, around, false, true);
    const auto north = static_cast<std::uint32_t>(mesh.positions.size()), south = north + 1;
    mesh.positions.push_back({0, 0, radius});
    mesh.positions.push_back({0, 0, -radius});
    for (std::uint32_t j = 0; j < around; ++j) {
        const std::uint32_t k = (j + 1) % around, last = (bands - 2) * around;
        mesh.faces.push_back({north, j, k});
        mesh.faces.push_back({south, last + k, last + j});
    }
    return mesh;
}

}  // namespace dgm::test
