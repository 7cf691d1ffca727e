// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut/cut_graph.h
// The network of edges along which a component is opened into a disk.
//
// [Erickson, Har-Peled 2004], [Erickson, Whittlesey 2005] greedy tree-cotree loops; [Gu, Gortler, Hoppe 2002] joining
// extremities to the cut.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/cut/disk.h"

namespace dgm::bake {

/// Neighbours of each vertex with edge lengths; built once a component.
struct VertexGraph {
    struct Arc {
        std::uint32_t to, half_edge;  ///< a half-edge between the two, either direction
        double length;
    };
    std::vector<std::uint32_t> first;  ///< arcs of vertex v: arcs[first[v]] .. arcs[first[v + 1] - 1]
    std::vector<Arc> arcs;
};

class CutGraph {
 public:
    /// The component must outlive the graph.
    explicit CutGraph(const TriMesh& component);

    /// Marks a short set of edges that opens the component into one disk: 2g loops for genus g, a path to every further
    /// boundary loop, and for a closed genus-0 component the path between two far points. Nothing for a disk.
    /// @param root  where the loops about the handles meet; kNone: at the middle of the surface
    void cut_to_disk(std::uint32_t root = kNone);

    /// Adds the shortest path from `vertex` to the cut (or to the border). Returns its length; 0 if it is on it
    /// already.
    double join(std::uint32_t vertex);

    /// Distance of each vertex to the cut and the border along edges.
    [[nodiscard]] std::vector<double> distance_to_cut() const;

    [[nodiscard]] Disk open() const;
    [[nodiscard]] double length() const;
    [[nodiscard]] bool is_cut(std::uint32_t half_edge) const { return cut_[half_edge] != 0; }
    /// Cuts or heals an edge (both half-edges).
    void mark(std::uint32_t half_edge, bool cut);
    [[nodiscard]] const VertexGraph& graph() const { return graph_; }

    [[nodiscard]] const TriMesh& mesh() const { return *mesh_; }
    [[nodiscard]] std::span<const std::uint32_t> opposite() const { return opposite_; }

    [[nodiscard]] std::int64_t genus() const { return genus_; }
    [[nodiscard]] std::size_t boundary_loop_count() const { return loops_.size(); }

 private:
    struct Search {
        std::vector<double> distance;
        std::vector<std::uint32_t> arc;  ///< arc by which a vertex was reached (index into arcs, from the vertex back)
    };
    /// Dijkstra from `sources`; stops at the first settled vertex for which `stop` holds and returns it.
    template <class Stop>
    std::uint32_t search(std::span<const std::uint32_t> sources, Stop stop, Search& out) const;
    void mark_path(const Search& search, std::uint32_t from);
    [[nodiscard]] std::uint32_t middle() const;
    void cut_handles(std::uint32_t root);
    void join_boundary_loops();
    struct Detours;
    void shorten();
    /// Replaces the cut path `half_edges` by the shortest one that opens the same surface; false if that is no shorter.
    bool reroute(std::span<const std::uint32_t> half_edges, double length, Detours& detours);
    void prune();
    [[nodiscard]] std::vector<std::uint32_t> cut_vertices() const;

    const TriMesh* mesh_;
    std::vector<std::uint32_t> opposite_;
    VertexGraph graph_;
    std::vector<std::uint32_t> loops_;  ///< one half-edge per boundary loop
    std::vector<char> cut_;             ///< per half-edge
    std::int64_t genus_ = 0;
};

}  // namespace dgm::bake
