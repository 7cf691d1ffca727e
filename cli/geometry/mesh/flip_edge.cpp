// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/flip_edge.cpp
#include "geometry/mesh/flip_edge.h"

namespace dgm::bake {
namespace {

/// True if an edge joins origin(h) and `vertex`.
bool are_joined(std::span<const Face> faces, std::span<const std::uint32_t> opposite, std::uint32_t h,
                std::uint32_t vertex) {
    // The fan of origin(h), one way round and from a border the other way.
    const auto has = [&](std::uint32_t out) {
        return target(faces, out) == vertex || origin(faces, previous_half_edge(out)) == vertex;
    };
    std::uint32_t g = h;
    do {
        if (has(g)) return true;
        g = opposite[previous_half_edge(g)];
    } while (g != kNone && g != h);
    if (g == h) return false;
    for (g = opposite[h]; g != kNone; g = opposite[next_half_edge(g)])
        if (has(next_half_edge(g))) return true;
    return false;
}

}  // namespace

bool may_flip(std::span<const Face> faces, std::span<const std::uint32_t> opposite, std::uint32_t h) {
    const std::uint32_t across = opposite[h];
    if (across == kNone) return false;
    const std::uint32_t third = previous_half_edge(h), other = origin(faces, previous_half_edge(across));
    return origin(faces, third) != other && !are_joined(faces, opposite, third, other);
}

void flip_edge(TriMesh& mesh, std::vector<std::uint32_t>& opposite, std::uint32_t h) {
    const std::uint32_t o = opposite[h];
    const std::uint32_t h1 = next_half_edge(h), h2 = previous_half_edge(h), o1 = next_half_edge(o),
                        o2 = previous_half_edge(o);
    const auto exchange = [&](auto& corners) {
        if (corners.empty()) return;
        corners[h1] = corners[o2];
        corners[o1] = corners[h2];
    };
    exchange(mesh.corner_normals);
    exchange(mesh.corner_uvs);
    exchange(mesh.corner_colours);
    const std::uint32_t r = origin(mesh.faces, h2), s = origin(mesh.faces, o2);
    mesh.faces[h1 / 3][h1 % 3] = s;
    mesh.faces[o1 / 3][o1 % 3] = r;
    const auto link = [&](std::uint32_t a, std::uint32_t b) {
        opposite[a] = b;
        if (b != kNone) opposite[b] = a;
    };
    const std::uint32_t beyond_s = opposite[o1], beyond_r = opposite[h1];
    link(h, beyond_s);
    link(o, beyond_r);
    link(h1, o1);
}

}  // namespace dgm::bake
