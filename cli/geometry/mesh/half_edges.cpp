// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/half_edges.cpp
// Finds the face across each edge: sorts directed edges by their ends, without hashing, so the order is the same
// everywhere.
#include "geometry/mesh/half_edges.h"

#include <algorithm>

namespace dgm::bake {

EdgeOrder::EdgeOrder(std::span<const Face> faces) {
    // Buckets by the lower end, in order of half-edges; each is a few entries long.
    std::uint32_t vertices = 0;
    for (const Face& f : faces)
        for (std::uint32_t v : f) vertices = std::max(vertices, v + 1);
    first_.assign(std::size_t{vertices} + 1, 0);
    for (std::uint32_t h = 0; h < faces.size() * 3; ++h) ++first_[std::min(origin(faces, h), target(faces, h)) + 1];
    for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
    entries_.resize(faces.size() * 3);
    std::vector<std::uint32_t> fill(first_.begin(), first_.end() - 1);
    for (std::uint32_t h = 0; h < faces.size() * 3; ++h) {
        const std::uint32_t a = origin(faces, h), b = target(faces, h);
        entries_[fill[std::min(a, b)]++] = {std::max(a, b), h};
    }
    for (std::uint32_t v = 0; v < vertices; ++v)
        std::sort(entries_.begin() + first_[v], entries_.begin() + first_[v + 1], [](const Entry& x, const Entry& y) {
            return x.high != y.high ? x.high < y.high : x.half_edge < y.half_edge;
        });
}

std::vector<std::uint32_t> opposite_half_edges(std::span<const Face> faces) {
    std::vector<std::uint32_t> opposite(faces.size() * 3, kNone);
    EdgeOrder(faces).each_edge([&](std::uint32_t, std::span<const EdgeOrder::Entry> of) {
        for (std::size_t k = 0; k + 1 < of.size(); k += 2) {
            opposite[of[k].half_edge] = of[k + 1].half_edge;
            opposite[of[k + 1].half_edge] = of[k].half_edge;
        }
    });
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
