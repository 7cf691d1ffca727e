// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/half_edges.cpp
// Finds the face across each edge: sorts directed edges by their ends, without hashing, so the order is the same
// everywhere.
#include "geometry/mesh/half_edges.h"

#include <algorithm>

namespace dgm::bake {

std::vector<std::uint32_t> opposite_half_edges(std::span<const Face> faces) {
    struct Entry {
        std::uint32_t high, half_edge;
    };
    // Buckets by the lower end, in order of half-edges; each is a few entries long.
    std::uint32_t vertices = 0;
    for (const Face& f : faces)
        for (std::uint32_t v : f) vertices = std::max(vertices, v + 1);
    std::vector<std::uint32_t> first(std::size_t{vertices} + 1, 0);
    for (std::uint32_t h = 0; h < faces.size() * 3; ++h) ++first[std::min(origin(faces, h), target(faces, h)) + 1];
    for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
    std::vector<Entry> entries(faces.size() * 3);
    std::vector<std::uint32_t> fill(first.begin(), first.end() - 1);
    for (std::uint32_t h = 0; h < faces.size() * 3; ++h) {
        const std::uint32_t a = origin(faces, h), b = target(faces, h);
        entries[fill[std::min(a, b)]++] = {std::max(a, b), h};
    }
    std::vector<std::uint32_t> opposite(faces.size() * 3, kNone);
    for (std::uint32_t v = 0; v < vertices; ++v) {
        const auto begin = entries.begin() + first[v], end = entries.begin() + first[v + 1];
        std::sort(begin, end, [](const Entry& x, const Entry& y) {
            return x.high != y.high ? x.high < y.high : x.half_edge < y.half_edge;
        });
        for (auto k = begin; k != end && k + 1 != end; ++k) {
            if (k->high != (k + 1)->high) continue;
            opposite[k->half_edge] = (k + 1)->half_edge;
            opposite[(k + 1)->half_edge] = k->half_edge;
            ++k;
        }
    }
    return opposite;
}

std::uint32_t next_border_half_edge(std::span<const std::uint32_t> opposite, std::uint32_t h) {
    std::uint32_t g = next_half_edge(h);
    while (opposite[g] != kNone) g = next_half_edge(opposite[g]);
    return g;
}

std::vector<std::uint32_t> boundary_loops(std::span<const std::uint32_t> opposite) {
    std::vector<std::uint32_t> loops;
    std::vector<bool> seen(opposite.size(), false);
    for (std::uint32_t h = 0; h < opposite.size(); ++h) {
        if (opposite[h] != kNone || seen[h]) continue;
        loops.push_back(h);
        for (std::uint32_t g = h; !seen[g]; g = next_border_half_edge(opposite, g)) seen[g] = true;
    }
    return loops;
}

}  // namespace dgm::bake
