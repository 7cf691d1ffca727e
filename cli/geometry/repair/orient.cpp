// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/orient.cpp
#include <cmath>
#include <string>

#include "geometry/repair/glue_edges.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

[[noreturn]] void two_sides_meet(std::uint32_t source_face) {
    throw model::Error(model::codes::kNonOrientable,
                       "the surface has no inside and outside: following it around, face " +
                           std::to_string(source_face) + " meets itself from its other side",
                       "face " + std::to_string(source_face));
}

struct Component {
    std::vector<std::uint32_t> faces;  ///< in the order in which the walk from the first one meets them
    bool closed = true;
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
                two_sides_meet(soup.source_face[g / 3]);
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
    return component.closed && mixed ? volume < 0 : turned_area > kept_area;
}

}  // namespace

Orientation orient(const FaceSoup& soup, std::span<const std::uint32_t> partner, RepairCounts& counts) {
    Orientation out;
    out.component.assign(soup.faces.size(), kNone);
    out.turned.assign(soup.faces.size(), 0);
    std::uint64_t turned_faces = 0;
    for (std::uint32_t seed = 0; seed < soup.faces.size(); ++seed) {
        if (out.component[seed] != kNone) continue;
        const Component component = walk_component(soup, partner, seed, out);
        const bool turn_all = is_inside_out(soup, component, out.turned);
        for (const std::uint32_t f : component.faces) {
            if (turn_all) out.turned[f] = static_cast<char>(!out.turned[f]);
            turned_faces += static_cast<std::uint64_t>(out.turned[f]);
        }
    }
    add_count(counts, "faces turned to agree with their neighbours", turned_faces);
    return out;
}

}  // namespace dgm::bake
