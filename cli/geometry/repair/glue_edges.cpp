// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/glue_edges.cpp
#include "geometry/repair/glue_edges.h"

#include <cmath>

#include "math/portable.h"

namespace dgm::bake {
namespace {

void glue(std::vector<std::uint32_t>& partner, std::uint32_t a, std::uint32_t b) {
    partner[a] = b;
    partner[b] = a;
}

/// Half-edges of one edge with the angles of their faces around it, ascending, from that of the first half-edge.
std::vector<std::pair<double, std::uint32_t>> sorted_by_angle(const FaceSoup& soup, std::uint32_t a, std::uint32_t b,
                                                              std::span<const std::uint32_t> group) {
    const Vec3d axis = normalized(soup.positions[b] - soup.positions[a]);
    const auto arm = [&](std::uint32_t h) {
        const std::uint32_t apex = soup.faces[h / 3][(h + 2) % 3];
        const Vec3d d = soup.positions[apex] - soup.positions[a];
        return d - axis * dot(d, axis);
    };
    const Vec3d x = normalized(arm(group[0]), Vec3d{1, 0, 0}), y = cross(axis, x);
    std::vector<std::pair<double, std::uint32_t>> around;
    for (const std::uint32_t h : group) {
        const Vec3d d = arm(h);
        around.emplace_back(h == group[0] ? 0.0 : std::fmod(math::atan2(dot(d, y), dot(d, x)) + 2 * M_PI, 2 * M_PI), h);
    }
    std::sort(around.begin(), around.end());
    return around;
}

/// A face is joined to the next one around the edge that runs the other way, so that two solids that touch along an
/// edge come apart as two solids. A half-edge without such a neighbour stays open.
void pair_by_angle(const FaceSoup& soup, std::span<const std::uint32_t> group, std::vector<std::uint32_t>& partner) {
    const std::uint32_t a = std::min(origin(soup.faces, group[0]), target(soup.faces, group[0]));
    const std::uint32_t b = std::max(origin(soup.faces, group[0]), target(soup.faces, group[0]));
    const auto around = sorted_by_angle(soup, a, b, group);
    // Seen along the axis, a face that runs a->b has its inside on the side of falling angle.
    const std::size_t n = around.size();
    std::vector<bool> taken(n, false);
    for (std::size_t k = 0; k < n; ++k) {
        const std::uint32_t h = around[k].second;
        if (taken[k] || origin(soup.faces, h) != a) continue;
        const std::size_t before = (k + n - 1) % n;
        if (taken[before] || origin(soup.faces, around[before].second) != b) continue;
        glue(partner, h, around[before].second);
        taken[k] = taken[before] = true;
    }
}

}  // namespace

std::vector<std::uint32_t> glue_edges(const FaceSoup& soup, RepairCounts& counts) {
    std::vector<std::uint32_t> partner(soup.faces.size() * 3, kNone);
    std::uint64_t non_manifold = 0;
    each_edge(soup.faces, [&](std::span<const std::uint32_t> group) {
        if (group.size() > 2) {
            ++non_manifold;
            pair_by_angle(soup, group, partner);
        } else if (group.size() == 2) {
            glue(partner, group[0], group[1]);
        }
    });
    add_count(counts, "non-manifold edges taken apart", non_manifold);
    return partner;
}

}  // namespace dgm::bake
