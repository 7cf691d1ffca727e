// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/vertex_corners.h
// The corners of the faces about each vertex.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/mesh/half_edges.h"

namespace dgm::bake {

/// Half-edges out of vertex v, ascending: of[first[v]] .. of[first[v + 1] - 1].
struct VertexCorners {
    std::vector<std::uint32_t> first, of;

    VertexCorners(std::span<const Face> faces, std::size_t vertex_count)
        : first(vertex_count + 1, 0), of(3 * faces.size()) {
        for (const Face& f : faces)
            for (std::uint32_t v : f) ++first[v + 1];
        for (std::size_t v = 0; v < vertex_count; ++v) first[v + 1] += first[v];
        std::vector<std::uint32_t> fill(first.begin(), first.end() - 1);
        for (std::uint32_t h = 0; h < 3 * faces.size(); ++h) of[fill[origin(faces, h)]++] = h;
    }
};

}  // namespace dgm::bake
