// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/build_components.cpp
#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "geometry/mesh/split_edge.h"
#include "geometry/mesh/union_find.h"
#include "geometry/repair/glue_edges.h"

namespace dgm::bake {
namespace {

/// Sets of corners (three to a face) that are one vertex: those that glued edges join.
UnionFind corners_by_vertex(const FaceSoup& soup, std::span<const std::uint32_t> partner) {
    UnionFind sets(soup.faces.size() * 3);
    const auto corner_at = [&](std::uint32_t h, std::uint32_t vertex) {
        return soup.faces[h / 3][h % 3] == vertex ? h : next_half_edge(h);
    };
    for (std::uint32_t h = 0; h < partner.size(); ++h) {
        const std::uint32_t g = partner[h];
        if (g == kNone || g < h) continue;
        for (const std::uint32_t v : {origin(soup.faces, h), target(soup.faces, h)})
            sets.unite(corner_at(h, v), corner_at(g, v));
    }
    return sets;
}

/// @param order  the source's corners in the order of the mesh's face
void copy_attributes(const TriMesh& source, std::uint32_t source_face, const std::array<std::uint32_t, 3>& order,
                     bool turned, TriMesh& mesh) {
    const std::size_t base = 3 * std::size_t{source_face};
    for (const std::uint32_t k : order) {
        if (!source.corner_normals.empty())
            mesh.corner_normals.push_back(turned ? -source.corner_normals[base + k] : source.corner_normals[base + k]);
        if (!source.corner_uvs.empty()) mesh.corner_uvs.push_back(source.corner_uvs[base + k]);
        if (!source.corner_colours.empty()) mesh.corner_colours.push_back(source.corner_colours[base + k]);
    }
    if (!source.face_materials.empty()) mesh.face_materials.push_back(source.face_materials[source_face]);
}

/// The edges on the two sides of an opening are found by their points alone (Disk::join_sides), so those whose points
/// another edge joins too get a vertex in the middle, on both sides.
std::uint64_t split_repeated_openings(TriMesh& mesh, std::vector<std::uint32_t>& partner,
                                      std::vector<std::uint32_t>& across) {
    const auto key = [&](std::uint32_t h) {
        const std::uint32_t a = mesh.points[origin(mesh.faces, h)], b = mesh.points[target(mesh.faces, h)];
        return std::pair{std::min(a, b), std::max(a, b)};
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> sides;
    for (std::uint32_t h = 0; h < across.size(); ++h)
        if (across[h] != kNone) sides.try_emplace(key(h), 0);
    for (std::uint32_t h = 0; h < across.size(); ++h)
        if (const auto found = sides.find(key(h)); found != sides.end()) ++found->second;
    std::uint64_t splits = 0;
    for (std::uint32_t h = 0; h < across.size(); ++h) {  // grows: a split moves half-edges to its end
        if (across[h] == kNone) continue;
        const auto found = sides.find(key(h));
        if (found == sides.end() || found->second <= 2) continue;
        split_edge(mesh, partner, h, 0.5, &across, true);
        ++splits;
    }
    return splits;
}

/// Gluing may leave two different edges between the same two vertices; the later ones get a vertex in the middle, so
/// that from here on an edge is known by its ends.
/// @param local_faces  of each face of the soup, its number in its component's mesh
std::uint64_t split_double_edges(std::vector<TriMesh>& meshes, const std::vector<std::uint32_t>& local_faces,
                                 std::span<const std::uint32_t> partner, const Orientation& orientation) {
    std::vector<std::vector<std::uint32_t>> partners(meshes.size()), across(meshes.size());
    for (std::size_t c = 0; c < partners.size(); ++c) {
        partners[c].assign(3 * meshes[c].faces.size(), kNone);
        if (orientation.one_sided[c]) across[c] = partners[c];
    }
    const auto local_half_edge = [&](std::uint32_t h) {
        if (h == kNone) return kNone;
        // A turned face has the corners (0, 2, 1): edge 0-1 is its last, 2-0 its first.
        static constexpr std::uint32_t kTurned[3] = {2, 1, 0};
        return 3 * local_faces[h / 3] + (orientation.turned[h / 3] ? kTurned[h % 3] : h % 3);
    };
    for (std::uint32_t h = 0; h < partner.size(); ++h) {
        const std::uint32_t c = orientation.component[h / 3];
        partners[c][local_half_edge(h)] = local_half_edge(partner[h]);
        if (!across[c].empty()) across[c][local_half_edge(h)] = local_half_edge(orientation.across[h]);
    }
    std::uint64_t split = 0;
    for (std::size_t c = 0; c < partners.size(); ++c)
        if (!across[c].empty()) split += split_repeated_openings(meshes[c], partners[c], across[c]);
    for (std::size_t c = 0; c < partners.size(); ++c) split += split_repeated_edges(meshes[c], partners[c]);
    return split;
}

}  // namespace

std::vector<TriMesh> build_components(const TriMesh& source, const FaceSoup& soup,
                                      std::span<const std::uint32_t> partner, const Orientation& orientation,
                                      RepairCounts& counts) {
    std::vector<std::uint32_t> joined(partner.begin(), partner.end());
    for (std::uint32_t h = 0; h < orientation.across.size(); ++h)
        if (orientation.across[h] != kNone) joined[h] = kNone;
    UnionFind vertex_sets = corners_by_vertex(soup, joined), point_sets = corners_by_vertex(soup, partner);
    std::vector<TriMesh> meshes(orientation.component_count);
    for (TriMesh& mesh : meshes) mesh.materials = source.materials;
    std::vector<std::uint32_t> local_vertex(soup.faces.size() * 3, kNone), local_point = local_vertex;  // of each set
    std::vector<std::uint32_t> local_faces(soup.faces.size());
    std::vector<bool> seen(soup.positions.size(), false);
    std::uint64_t split = 0;
    for (std::uint32_t f = 0; f < soup.faces.size(); ++f) {
        TriMesh& mesh = meshes[orientation.component[f]];
        const bool turned = orientation.turned[f] != 0;
        Face face;
        std::array<std::uint32_t, 3> order{0, 1, 2};
        if (turned) std::swap(order[1], order[2]);
        for (std::uint32_t k = 0; k < 3; ++k) {
            std::uint32_t& vertex = local_vertex[vertex_sets.find(3 * f + order[k])];
            if (vertex == kNone) {
                const std::uint32_t v = soup.faces[f][order[k]];
                vertex = static_cast<std::uint32_t>(mesh.positions.size());
                mesh.positions.push_back(soup.positions[v]);
                std::uint32_t& point = local_point[point_sets.find(3 * f + order[k])];
                if (point == kNone) {
                    point = vertex;
                    split += seen[v];
                    seen[v] = true;
                }
                if (orientation.one_sided[orientation.component[f]]) mesh.points.push_back(point);
            }
            face[k] = vertex;
        }
        local_faces[f] = static_cast<std::uint32_t>(mesh.faces.size());
        mesh.faces.push_back(face);
        copy_attributes(source, soup.source_face[f], order, turned, mesh);
    }
    add_count(counts, "vertices split where surfaces only touch", split);
    add_count(counts, "double edges split", split_double_edges(meshes, local_faces, joined, orientation));
    return meshes;
}

}  // namespace dgm::bake
