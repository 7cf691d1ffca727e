// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut/disk.h
// A component opened along its cut: the surface that gets parameterized.
#pragma once
#include <cstdint>
#include <vector>

#include "geometry/mesh/half_edges.h"
#include "geometry/mesh/split_edge.h"

namespace dgm::bake {

/// One stretch of the disk's border between two nodes (cut nodes, ends of the real border, marked corners of the real
/// border). An interior cut path stands twice, as two paths that are each other's mate and run in opposite directions:
/// in the same direction where a surface without an inside was opened.
struct BorderPath {
    std::vector<std::uint32_t> half_edges;  ///< in border order, surface on the left
    std::uint32_t mate = kNone;             ///< index of the mate, kNone on the real border
    double length = 0;
    bool is_loop = false;   ///< starts and ends at one surface point
    bool same_way = false;  ///< runs in the direction of its mate
    bool parallel = false;  ///< a path that is not its mate joins the same two surface points
};

struct Disk {
    TriMesh mesh;
    std::vector<std::uint32_t> weld;  ///< per vertex: id of its surface point; copies along the cut share it
    std::uint32_t weld_count = 0;
    std::vector<std::uint32_t> opposite;  ///< kNone along the disk's border
    std::vector<std::uint32_t> mate;      ///< per half-edge: the other side of the cut, kNone elsewhere

    /// The border cycle as half-edges, surface on the left, starting at the lowest border half-edge.
    [[nodiscard]] std::vector<std::uint32_t> border() const;
    /// The border cycle cut into paths, first path starting at a node. A real border turning by more than
    /// `corner_degrees` within the surface gets a node there.
    [[nodiscard]] std::vector<BorderPath> paths(double corner_degrees = 50) const;
    /// Joins the two sides along which a surface without an inside was opened (`mesh.points`): their half-edges become
    /// mates that run in the same direction, and vertices of one point share the lowest of their weld ids. Without such
    /// sides, or a second time, it changes nothing.
    void join_sides();
    /// True if h runs in the direction of its mate. The edges of a joined side have different points at their ends.
    [[nodiscard]] bool same_way(std::uint32_t h) const {
        return mate[h] != kNone && weld[origin(mesh.faces, h)] == weld[origin(mesh.faces, mate[h])] &&
               weld[target(mesh.faces, h)] == weld[target(mesh.faces, mate[h])];
    }
    /// Per vertex, 1 where the faces around it wind against those around the first vertex of its surface point; empty
    /// if there is no such vertex.
    [[nodiscard]] std::vector<std::uint8_t> reversed_vertices() const;
    /// Splits the edge of `h` at parameter t, and its mate at the mirrored place with the same position and weld id.
    NewVertices split(std::uint32_t h, double t);
};

}  // namespace dgm::bake
