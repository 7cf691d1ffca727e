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
/// border). An interior cut path stands twice, as two paths that are each other's mate and run in opposite directions.
struct BorderPath {
    std::vector<std::uint32_t> half_edges;  ///< in border order, surface on the left
    std::uint32_t mate = kNone;             ///< index of the mate, kNone on the real border
    double length = 0;
    bool is_loop = false;  ///< starts and ends at one surface point
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
    /// Splits the edge of `h` at parameter t, and its mate at the mirrored place with the same position and weld id.
    NewVertices split(std::uint32_t h, double t);
};

}  // namespace dgm::bake
