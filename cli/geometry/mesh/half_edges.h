// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/half_edges.h
// Finds the face across each edge. Half-edge 3*f+k runs from corner k of face f to corner k+1.
#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "geometry/mesh/triangle.h"
#include "model/tri_mesh.h"

namespace dgm::bake {

using model::Face;
using model::TriMesh;

inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

[[nodiscard]] constexpr std::uint32_t next_half_edge(std::uint32_t h) {
    return h % 3 == 2 ? h - 2 : h + 1;
}
[[nodiscard]] constexpr std::uint32_t previous_half_edge(std::uint32_t h) {
    return h % 3 == 0 ? h + 2 : h - 1;
}
[[nodiscard]] inline std::uint32_t origin(std::span<const Face> faces, std::uint32_t h) {
    return faces[h / 3][h % 3];
}
[[nodiscard]] inline std::uint32_t target(std::span<const Face> faces, std::uint32_t h) {
    return faces[h / 3][(h + 1) % 3];
}

/// The half-edges of `faces` in the order of their edges: by the lower end, then the higher one, then by number.
class EdgeOrder {
 public:
    struct Entry {
        std::uint32_t high, half_edge;
    };
    explicit EdgeOrder(std::span<const Face> faces);

    /// Calls visit(low, entries) for the half-edges of each undirected edge, in order.
    template <class Visit>
    void each_edge(const Visit& visit) const {
        for (std::uint32_t low = 0; low + 1 < first_.size(); ++low)
            for (std::uint32_t k = first_[low], end = k; k < first_[low + 1]; k = end) {
                while (end < first_[low + 1] && entries_[end].high == entries_[k].high) ++end;
                visit(low, std::span(entries_).subspan(k, end - k));
            }
    }

 private:
    std::vector<std::uint32_t> first_;  // entry of each lower end; one more at the end
    std::vector<Entry> entries_;
};

/// Opposite half-edge of each half-edge, kNone on a border. The faces must be an oriented manifold without two edges
/// between the same vertices, as repair() returns them.
[[nodiscard]] std::vector<std::uint32_t> opposite_half_edges(std::span<const Face> faces);

/// The border half-edge that follows border half-edge `h` along its loop, surface on the left.
[[nodiscard]] std::uint32_t next_border_half_edge(std::span<const std::uint32_t> opposite, std::uint32_t h);

/// One border half-edge per boundary loop, lowest half-edge of each.
[[nodiscard]] std::vector<std::uint32_t> boundary_loops(std::span<const std::uint32_t> opposite);

}  // namespace dgm::bake
