// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/weld_open_vertices.cpp
#include <cmath>
#include <limits>
#include <tuple>
#include <unordered_map>

#include "geometry/mesh/union_find.h"
#include "geometry/repair/face_soup.h"

namespace dgm::bake {
namespace {

constexpr double kLargestTolerance = 1e-6, kShareOfEdge = 1e-3;

/// Shortest open edge at each vertex (edges that one face alone uses); infinity for vertices without one.
std::vector<double> shortest_open_edge(const FaceSoup& soup) {
    std::vector<double> shortest(soup.positions.size(), std::numeric_limits<double>::infinity());
    each_edge(soup.faces, [&](std::span<const std::uint32_t> group) {
        if (group.size() != 1) return;
        const std::uint32_t a = origin(soup.faces, group[0]), b = target(soup.faces, group[0]);
        if (a == b) return;
        const double l = length(soup.positions[a] - soup.positions[b]);
        shortest[a] = std::min(shortest[a], l);
        shortest[b] = std::min(shortest[b], l);
    });
    return shortest;
}

/// Unites open vertices at the same position. @return how many sets became one with another
std::uint64_t unite_equal(const FaceSoup& soup, UnionFind& sets) {
    const std::vector<double> shortest = shortest_open_edge(soup);
    std::vector<std::uint32_t> open;
    for (std::uint32_t v = 0; v < shortest.size(); ++v)
        if (std::isfinite(shortest[v])) open.push_back(v);
    const auto key = [&](std::uint32_t v) {
        const Vec3d& p = soup.positions[v];
        return std::tuple(p.x + 0.0, p.y + 0.0, p.z + 0.0);  // + 0.0 makes -0 and 0 one
    };
    std::sort(open.begin(), open.end(),
              [&](std::uint32_t a, std::uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
    std::uint64_t united = 0;
    for (std::size_t k = 1; k < open.size(); ++k)
        if (key(open[k]) == key(open[k - 1])) united += sets.unite(open[k - 1], open[k]);
    return united;
}

/// A cell as large as the largest tolerance, `d` cells away from the one that holds `p`.
std::uint64_t cell_near(const Vec3d& p, int dx, int dy, int dz) {
    const auto part = [](double x, int d) {
        return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x / kLargestTolerance)) + d +
                                          (1 << 20)) &
               0x1fffff;
    };
    return part(p.x, dx) << 42 | part(p.y, dy) << 21 | part(p.z, dz);
}

/// Unites open vertices within a share of their shortest open edge. @return how many sets became one with another
std::uint64_t unite_near(const FaceSoup& soup, UnionFind& sets) {
    const std::vector<double> shortest = shortest_open_edge(soup);
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells;
    std::uint64_t united = 0;
    for (std::uint32_t v = 0; v < shortest.size(); ++v) {
        if (!std::isfinite(shortest[v])) continue;
        for (int k = 0; k < 27; ++k) {
            const auto it = cells.find(cell_near(soup.positions[v], k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1));
            if (it == cells.end()) continue;
            for (const std::uint32_t w : it->second) {
                const double tolerance = std::min(kLargestTolerance, kShareOfEdge * std::min(shortest[v], shortest[w]));
                if (length(soup.positions[v] - soup.positions[w]) <= tolerance) united += sets.unite(v, w);
            }
        }
        cells[cell_near(soup.positions[v], 0, 0, 0)].push_back(v);
    }
    return united;
}

void replace_by_representatives(FaceSoup& soup, UnionFind& sets) {
    for (Face& face : soup.faces)
        for (std::uint32_t& v : face) v = sets.find(v);
}

}  // namespace

void weld_open_vertices(FaceSoup& soup, RepairCounts& counts) {
    UnionFind sets(soup.positions.size());
    const std::uint64_t equal = unite_equal(soup, sets);
    replace_by_representatives(soup, sets);
    // The exact weld closed edges; the tolerance is for vertices on those that are still open.
    const std::uint64_t near = unite_near(soup, sets);
    replace_by_representatives(soup, sets);
    add_count(counts, "open vertices welded", equal);
    add_count(counts, "nearly coincident open vertices welded", near);
}

}  // namespace dgm::bake
