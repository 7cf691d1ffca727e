// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/split_edge.cpp
// Face (a, b, c) with n on a-b becomes (a, n, c) in place and (n, b, c) at the end, corners keeping their slots.
#include "geometry/mesh/split_edge.h"

#include <algorithm>
#include <cmath>

namespace dgm::bake {
namespace {

/// Room for `count` more: a disk of a million faces is split a few hundred times, and twice its room would be wasted.
template <class T>
void make_room(std::vector<T>& of, std::size_t count) {
    if (of.capacity() - of.size() < count) of.reserve(of.size() + std::max(count, of.size() / 8));
}

template <class T>
void add(std::vector<T>& to, const T& value) {
    make_room(to, 1);
    to.push_back(value);
}

template <class T>
void split_corners(std::vector<T>& corners, std::uint32_t f, const std::uint32_t slot[3], const T& middle) {
    if (corners.empty()) return;
    T second[3];
    second[slot[0]] = middle;
    second[slot[1]] = corners[3 * f + slot[1]];
    second[slot[2]] = corners[3 * f + slot[2]];
    corners[3 * f + slot[1]] = middle;
    make_room(corners, 3);
    corners.insert(corners.end(), second, second + 3);
}

std::uint8_t mix(std::uint8_t a, std::uint8_t b, double t) {
    return static_cast<std::uint8_t>(std::lround(a + (b - a) * t));
}

}  // namespace

FaceSplit split_face(TriMesh& mesh, std::uint32_t h, std::uint32_t n, double t) {
    const std::uint32_t f = h / 3, g = static_cast<std::uint32_t>(mesh.faces.size());
    const std::uint32_t slot[3] = {h % 3, (h + 1) % 3, (h + 2) % 3};
    if (!mesh.corner_normals.empty()) {
        const Vec3d a = mesh.corner_normals[3 * f + slot[0]], b = mesh.corner_normals[3 * f + slot[1]];
        split_corners(mesh.corner_normals, f, slot, normalized(a * (1 - t) + b * t, Vec3d{}));
    }
    if (!mesh.corner_uvs.empty()) {
        const Vec2d a = mesh.corner_uvs[3 * f + slot[0]], b = mesh.corner_uvs[3 * f + slot[1]];
        split_corners(mesh.corner_uvs, f, slot, a * (1 - t) + b * t);
    }
    if (!mesh.corner_colours.empty()) {
        const auto a = mesh.corner_colours[3 * f + slot[0]], b = mesh.corner_colours[3 * f + slot[1]];
        split_corners(mesh.corner_colours, f, slot,
                      model::Rgba8{mix(a.r, b.r, t), mix(a.g, b.g, t), mix(a.b, b.b, t), mix(a.a, b.a, t)});
    }
    if (!mesh.face_materials.empty()) add(mesh.face_materials, std::uint32_t{mesh.face_materials[f]});
    Face second;
    second[slot[0]] = n;
    second[slot[1]] = mesh.faces[f][slot[1]];
    second[slot[2]] = mesh.faces[f][slot[2]];
    mesh.faces[f][slot[1]] = n;
    add(mesh.faces, second);
    return {3 * g + slot[0], 3 * f + slot[1], 3 * g + slot[1]};
}

NewVertices split_edge(TriMesh& mesh, std::vector<std::uint32_t>& opposite, std::uint32_t h, double t,
                       std::vector<std::uint32_t>* mate, bool same_way) {
    const Vec3d a = mesh.positions[origin(mesh.faces, h)], b = mesh.positions[target(mesh.faces, h)];
    const Vec3d middle = a * (1 - t) + b * t;
    const auto add_vertex = [&] {
        const auto added = static_cast<std::uint32_t>(mesh.positions.size());
        add(mesh.positions, middle);
        if (!mesh.points.empty()) add(mesh.points, added);
        return added;
    };
    const auto split_side = [&](std::uint32_t side, std::uint32_t n, double at) {
        const FaceSplit s = split_face(mesh, side, n, at);
        for (std::vector<std::uint32_t>* links : {&opposite, mate}) {
            if (links == nullptr) continue;
            make_room(*links, 3 * mesh.faces.size() - links->size());
            links->resize(3 * mesh.faces.size(), kNone);
            const std::uint32_t across = (*links)[s.moved_to] = (*links)[s.moved_from];
            if (across != kNone) (*links)[across] = s.moved_to;
            (*links)[s.moved_from] = kNone;
        }
        const std::uint32_t inner = next_half_edge(s.moved_to);  // c -> n in the new face meets n -> c in the old one
        opposite[s.moved_from] = inner;
        opposite[inner] = s.moved_from;
        return s;
    };
    const bool across_cut = opposite[h] == kNone && mate != nullptr && (*mate)[h] != kNone;
    std::uint32_t other = across_cut ? (*mate)[h] : opposite[h];
    NewVertices out{add_vertex(), kNone, h};
    const FaceSplit first = split_side(h, out.vertex, t);
    if (other == kNone) return out;
    if (across_cut) out.twin = add_vertex();
    if (across_cut && same_way && !mesh.points.empty()) mesh.points[out.twin] = out.vertex;
    if (other == first.moved_from) other = first.moved_to;  // both sides lie in one face
    const FaceSplit second = split_side(other, across_cut ? out.twin : out.vertex, same_way ? t : 1 - t);
    const std::uint32_t here = out.first = h == second.moved_from ? second.moved_to : h;
    std::vector<std::uint32_t>& links = across_cut ? *mate : opposite;
    const std::uint32_t by_here = same_way ? other : second.second, by_second = same_way ? second.second : other;
    links[here] = by_here;
    links[by_here] = here;
    links[by_second] = first.second;
    links[first.second] = by_second;
    return out;
}

std::uint64_t split_repeated_edges(TriMesh& mesh, std::vector<std::uint32_t>& partner) {
    struct Repeated {
        std::uint32_t low, high, half_edge;
    };
    std::vector<Repeated> repeated;
    EdgeOrder(mesh.faces).each_edge([&](std::uint32_t low, std::span<const EdgeOrder::Entry> of) {
        std::size_t seen = 0;
        for (const EdgeOrder::Entry& e : of)
            if ((partner[e.half_edge] == kNone || partner[e.half_edge] > e.half_edge) && ++seen > 1)
                repeated.push_back({low, e.high, e.half_edge});
    });
    std::uint64_t splits = 0;
    for (const Repeated& edge : repeated) {
        // A split before this one may have moved the half-edge into another face; its ends decide.
        const auto joins = [&](std::uint32_t h) {
            const std::uint32_t a = origin(mesh.faces, h), b = target(mesh.faces, h);
            return std::min(a, b) == edge.low && std::max(a, b) == edge.high;
        };
        std::uint32_t h = edge.half_edge;
        if (!joins(h)) {
            h = kNone;
            std::uint64_t seen = 0;
            for (std::uint32_t g = 0; g < partner.size(); ++g)
                if ((partner[g] == kNone || partner[g] > g) && joins(g) && ++seen > 1) h = g;
            if (h == kNone) continue;
        }
        split_edge(mesh, partner, h, 0.5);
        ++splits;
    }
    return splits;
}

}  // namespace dgm::bake
