// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/orient.cpp
#include <cmath>

#include "geometry/repair/glue_edges.h"
#include "geometry/repair/open_one_sided.h"

namespace dgm::bake {
namespace {

struct Component {
    std::vector<std::uint32_t> faces;  ///< in the order in which the walk from the first one meets them
    bool closed = true;
    bool one_sided = false;  ///< a face meets itself from its other side
};

/// Walks from `seed` over glued edges; each face gets the component's number, and is reversed if its neighbour requires
/// it.
Component walk_component(const FaceSoup& soup, std::span<const std::uint32_t> partner, std::uint32_t seed,
                         Orientation& out) {
    const std::uint32_t id = out.component_count++;
    Component walked;
    walked.faces.push_back(seed);
    out.component[seed] = id;
    for (std::size_t at = 0; at < walked.faces.size(); ++at) {
        const std::uint32_t f = walked.faces[at];
        for (std::uint32_t h = 3 * f; h < 3 * f + 3; ++h) {
            const std::uint32_t g = partner[h];
            if (g == kNone) {
                walked.closed = false;
                continue;
            }
            const bool agree = origin(soup.faces, h) != origin(soup.faces, g);
            const char expected = agree ? out.turned[f] : static_cast<char>(!out.turned[f]);
            if (out.component[g / 3] == kNone) {
                out.component[g / 3] = id;
                out.turned[g / 3] = expected;
                walked.faces.push_back(g / 3);
            } else if (out.turned[g / 3] != expected) {
                walked.one_sided = true;
            }
        }
    }
    return walked;
}

/// Whether the component, with its faces turned to agree, is to be turned as a whole.
bool is_inside_out(const FaceSoup& soup, const Component& component, const std::vector<char>& turned) {
    double kept_area = 0, turned_area = 0, volume = 0;
    for (const std::uint32_t f : component.faces) {
        const auto q = soup.corners(f);
        (turned[f] ? turned_area : kept_area) += face_area(q);
        volume += (turned[f] ? -1 : 1) * dot(q[0], cross(q[1], q[2]));
    }
    const bool mixed = std::min(kept_area, turned_area) > 0.1 * (kept_area + turned_area);
    return component.closed && mixed && !component.one_sided ? volume < 0 : turned_area > kept_area;
}

}  // namespace

Orientation orient(const FaceSoup& soup, std::span<const std::uint32_t> partner, RepairCounts& counts) {
    Orientation out;
    out.component.assign(soup.faces.size(), kNone);
    out.turned.assign(soup.faces.size(), 0);
    std::uint64_t turned_faces = 0;
    bool any_one_sided = false;
    for (std::uint32_t seed = 0; seed < soup.faces.size(); ++seed) {
        if (out.component[seed] != kNone) continue;
        const Component component = walk_component(soup, partner, seed, out);
        out.one_sided.push_back(component.one_sided);
        if (component.one_sided) {
            any_one_sided = true;
            open_one_sided(soup, component.faces, partner, out.turned);
        }
        const bool turn_all = is_inside_out(soup, component, out.turned);
        for (const std::uint32_t f : component.faces) {
            if (turn_all) out.turned[f] = static_cast<char>(!out.turned[f]);
            turned_faces += static_cast<std::uint64_t>(out.turned[f]);
        }
    }
    add_count(counts, "faces turned to agree with their neighbours", turned_faces);
    if (any_one_sided) {
        out.across.assign(partner.size(), kNone);
        for (std::uint32_t h = 0; h < partner.size(); ++h) {
            const std::uint32_t g = partner[h];
            if (g == kNone) continue;
            const bool agree = origin(soup.faces, h) != origin(soup.faces, g);
            if (agree != (out.turned[h / 3] == out.turned[g / 3])) out.across[h] = g;
        }
    }
    return out;
}

}  // namespace dgm::bake
