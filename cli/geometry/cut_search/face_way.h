// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/face_way.h
// Finds and measures ways on a mesh that run along edges and across faces.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/cut/cut_graph.h"

namespace dgm::bake {

/// A vertex, or a place on an edge; half-edges of places run along the face on the way's far side.
struct Place {
    std::uint32_t vertex = kNone, half_edge = kNone;
    double at = 0;  ///< from the half-edge's origin to its target
};

[[nodiscard]] Vec3d position_at(const TriMesh& mesh, const Place& place);

/// The face that two places in a row have in common; kNone if the way runs along an edge there.
[[nodiscard]] std::uint32_t face_between(const CutGraph& cut, const Place& a, const Place& b);

/// Cost of a way along edges, as CutGraph::weigh() set it; infinity if two vertices in a row have no edge.
[[nodiscard]] double way_cost(const CutGraph& cut, std::span<const std::uint32_t> vertices);
/// The same of a way across faces: a face costs as much a length as its edges do on average.
[[nodiscard]] double way_cost(const CutGraph& cut, std::span<const Place> way);

/// Slides each crossing along its edge to where the way is shortest between its neighbours, again and again.
void relax_way(const TriMesh& mesh, std::span<Place> way);

/// The parts of a mesh that ways may not use.
class Occupied {
 public:
    /// Occupies the border, and the edges and vertices of the cut.
    /// @param cut  must outlive the object
    explicit Occupied(const CutGraph& cut);

    /// Occupies or frees the edges of a way along edges, and its vertices but the ends.
    void set_edges(std::span<const std::uint32_t> vertices, bool occupied);
    /// Occupies a way, and names its crossings by the half-edges beyond them: splitting one leaves those of the others
    /// as they are. False, and nothing done, if it passes a face twice.
    [[nodiscard]] bool add(std::span<Place> way);

    [[nodiscard]] bool vertex(std::uint32_t v) const { return vertices_[v] != 0; }
    [[nodiscard]] bool face(std::uint32_t f) const { return faces_[f] != 0; }
    [[nodiscard]] bool half_edge(std::uint32_t h) const { return half_edges_[h] != 0; }

 private:
    const CutGraph& cut_;
    std::vector<char> vertices_;    // on a way or on the border
    std::vector<char> faces_;       // a way runs through it
    std::vector<char> half_edges_;  // on the border, or a way runs along it or across it
};

/// The shortest way near a path, over free vertices and across free edges of free faces; empty if there is none.
/// @param near  per vertex: the way may pass it, or an edge of it
[[nodiscard]] std::vector<Place> shortest_way(const CutGraph& cut, const Occupied& occupied, std::span<const char> near,
                                              std::uint32_t from, std::uint32_t to);

}  // namespace dgm::bake
