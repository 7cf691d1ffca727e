// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/face_soup.h
// Holds the faces of a source before they are glued, drops the unusable ones, and welds open vertices.
#pragma once
#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "geometry/mesh/half_edges.h"
#include "geometry/repair/repair.h"
#include "geometry/repair/repair_counts.h"

namespace dgm::bake {

/// Faces by vertex index, in the source's order; nothing is known about how they meet.
struct FaceSoup {
    std::vector<Vec3d> positions;  ///< those of the source, in its order; unused ones are 0 once normalised
    std::vector<Face> faces;
    std::vector<std::uint32_t> source_face;  ///< of each face

    [[nodiscard]] std::array<Vec3d, 3> corners(std::size_t f) const {
        return {positions[faces[f][0]], positions[faces[f][1]], positions[faces[f][2]]};
    }
};

/// Takes the faces whose corners exist and are finite.
/// @throws model::Error kNoFaces if there is none
[[nodiscard]] FaceSoup usable_faces(const TriMesh& source, RepairCounts& counts);

/// Moves the soup to the centre of its bounding box and scales the box's diagonal to 1.
/// @throws model::Error kNoFaces if all vertices coincide, kScaleOutOfRange if the box overflows
[[nodiscard]] Frame normalise(FaceSoup& soup, RepairCounts& counts);

/// Welds vertices on open edges: exactly first, then within a tolerance (repair.h, step 2).
void weld_open_vertices(FaceSoup& soup, RepairCounts& counts);

void drop_repeated_corners(FaceSoup& soup, RepairCounts& counts);
/// Keeps the first of the faces with the same three vertices, in whatever order.
void drop_duplicate_faces(FaceSoup& soup, RepairCounts& counts);

/// Calls `visit` with the half-edges of each undirected edge, in a fixed order.
template <class Visit>
void each_edge(std::span<const Face> faces, Visit visit) {
    std::vector<std::uint32_t> group;
    EdgeOrder(faces).each_edge([&](std::uint32_t, std::span<const EdgeOrder::Entry> of) {
        group.clear();
        for (const EdgeOrder::Entry& e : of) group.push_back(e.half_edge);
        visit(std::span<const std::uint32_t>(group));
    });
}

}  // namespace dgm::bake
