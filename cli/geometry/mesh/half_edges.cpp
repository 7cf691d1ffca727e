// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/half_edges.cpp
// Who lies across each edge: one sort of the directed edges, no hashing, so the order is the same everywhere.
#include "geometry/mesh/half_edges.h"

#include <algorithm>

namespace dgm::bake {

std::vector<std::uint32_t> opposite_half_edges(std::span<const Face> faces) {
    struct Entry {
        std::uint64_t key;
        std::uint32_t half_edge;
    };
    std::vector<Entry> entries;
    entries.reserve(faces.size() * 3);
    for (std::uint32_t h = 0; h < faces.size() * 3; ++h) {
        const std::uint32_t a = origin(faces, h), b = target(faces, h);
        entries.push_back({std::uint64_t{std::min(a, b)} << 32 | std::max(a, b), h});
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& x, const Entry& y) {
        return x.key != y.key ? x.key < y.key : x.half_edge < y.half_edge;
    });
    std::vector<std::uint32_t> opposite(faces.size() * 3, kNone);
    for (std::size_t k = 0; k + 1 < entries.size(); ++k) {
        if (entries[k].key != entries[k + 1].key) continue;
        opposite[entries[k].half_edge] = entries[k + 1].half_edge;
        opposite[entries[k + 1].half_edge] = entries[k].half_edge;
        ++k;
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
