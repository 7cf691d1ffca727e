// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut/cut_graph.h
// The network of edges along which a component is opened into a disk.
//
// [Erickson, Har-Peled 2004], [Erickson, Whittlesey 2005] greedy tree-cotree loops; [Gu, Gortler, Hoppe 2002] joining
// extremities to the cut.
#pragma once
#include <algorithm>
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
        double cost;  ///< the cost that shortest paths add up: the length, unless CutGraph::weigh() has changed it
    };
    std::vector<std::uint32_t> first;  ///< arcs of vertex v: arcs[first[v]] .. arcs[first[v + 1] - 1]
    std::vector<Arc> arcs;
};

/// Where the cut of a component without borders begins. A search from each ends at another cut.
enum class CutStart {
    kLong,   ///< with a path between two points as far apart as they get
    kAside,  ///< with a path from the point farthest from that one to the point farthest from there
    kShort   ///< with half of that: as far from its first point as half of all vertices are
};

class CutGraph {
 public:
    /// The component must outlive the graph.
    explicit CutGraph(const TriMesh& component);

    /// Marks a short set of edges that opens the component into one disk: 2g loops for genus g, a path to every further
    /// boundary loop, and for a closed genus-0 component the path between two far points. Nothing for a disk.
    /// @param root  where the loops about the handles meet; kNone: at the middle of the surface
    /// @param start  of a closed genus-0 component; others begin as they do for kLong
    void cut_to_disk(std::uint32_t root = kNone, CutStart start = CutStart::kLong);

    /// From now on an edge costs its length times the factor of its lower half-edge, and paths are shortest by cost.
    /// Factors are positive.
    void weigh(std::span<const double> factors);

    /// Adds the shortest path from `vertex` to the cut (or to the border). Returns its cost; 0 if it is on it already.
    double join(std::uint32_t vertex);

    /// Adds the shortest path between two vertices that meets the cut and the border nowhere else. Returns its cost;
    /// infinity, and nothing marked, if there is no such path.
    double connect(std::uint32_t from, std::uint32_t to);

    /// Distance of each vertex to the cut and the border along edges, in cost.
    [[nodiscard]] std::vector<double> distance_to_cut() const;
    /// The same where `distance` is that to a part of the cut: visits only what has come nearer since.
    void follow_cut(std::vector<double>& distance) const;

    /// Per vertex, nonzero where a dead end of the cut ends.
    [[nodiscard]] std::vector<char> tips() const;

    /// True if the surface without the cut and the border is one open disk.
    [[nodiscard]] bool opens_to_disk() const;
    /// The weld ids are the component's vertices. Sides along which the component was opened are not joined.
    [[nodiscard]] Disk open() const;
    [[nodiscard]] double length() const;
    /// Cost of the shortest path between two points as far apart as two sweeps find.
    [[nodiscard]] double longest_way() const;
    [[nodiscard]] double edge_cost(std::uint32_t half_edge) const;
    /// Factor of an edge by weigh(); 1 without.
    [[nodiscard]] double factor(std::uint32_t half_edge) const {
        // kNone is the largest number.
        return factors_.empty() ? 1 : factors_[std::min(half_edge, opposite_[half_edge])];
    }
    [[nodiscard]] bool is_cut(std::uint32_t half_edge) const { return cut_[half_edge] != 0; }
    /// Cuts or heals an edge (both half-edges).
    void mark(std::uint32_t half_edge, bool cut);
    [[nodiscard]] const VertexGraph& graph() const { return graph_; }

    [[nodiscard]] const TriMesh& mesh() const { return *mesh_; }
    [[nodiscard]] std::span<const std::uint32_t> opposite() const { return opposite_; }

    [[nodiscard]] std::int64_t genus() const { return genus_; }
    [[nodiscard]] std::size_t boundary_loop_count() const { return loops_.size(); }

 private:
    void mark_first_path(CutStart start);
    struct Search {
        std::vector<double> distance;
        std::vector<std::uint32_t> arc;  ///< arc by which a vertex was reached (index into arcs, from the vertex back)
    };
    /// Dijkstra from `sources`; stops at the first settled vertex for which `stop` holds and returns it. Where
    /// `closed` is given, it enters no vertex for which it is set, and takes no edge of the cut.
    template <class Stop>
    std::uint32_t search(std::span<const std::uint32_t> sources, Stop stop, Search& out,
                         std::span<const char> closed = {}) const;
    void mark_path(const Search& search, std::uint32_t from);
    /// The vertex farthest from `from`; distances and ways are left in `out`.
    std::uint32_t farthest(std::uint32_t from, Search& out) const;
    [[nodiscard]] std::uint32_t middle() const;
    void cut_handles(std::uint32_t root);
    void join_boundary_loops();
    struct Detours;
    void shorten();
    /// Replaces the cut path `half_edges` by the cheapest one that opens the same surface; false if that is no cheaper.
    bool reroute(std::span<const std::uint32_t> half_edges, double cost, Detours& detours);
    void prune();
    [[nodiscard]] std::vector<std::uint32_t> cut_vertices() const;
    /// Number of cut edges at each vertex.
    [[nodiscard]] std::vector<std::uint32_t> cut_degrees() const;

    const TriMesh* mesh_;
    std::vector<std::uint32_t> opposite_;
    VertexGraph graph_;
    std::vector<std::uint32_t> loops_;  ///< one half-edge per boundary loop
    std::vector<char> cut_;             ///< per half-edge
    std::vector<double> factors_;       ///< of cost, per half-edge; empty: 1
    std::int64_t genus_ = 0;
};

}  // namespace dgm::bake
