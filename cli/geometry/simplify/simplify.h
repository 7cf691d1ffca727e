// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/simplify/simplify.h
// A coarse mesh on a subset of a fine mesh's vertices, and the way back.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/mesh/half_edges.h"
#include "model/progress.h"

namespace dgm::bake {

struct SimplifyOptions {
    double border_weight = 10;     ///< of the planes that hold the border in place, against the faces' own
    double regularity = 1e-4;      ///< cost of an edge's squared length against squared distances to the planes
    double least_cosine = 0.2;     ///< between the normals of a face before and after a collapse
    std::size_t max_valence = 24;  ///< of the vertex that stays
    bool allow_chords = true;      ///< edges through the inside that join two border vertices may arise
    std::span<const char> locked;  ///< per vertex, nonzero: never removed; empty: none
};

/// One half-edge collapse: `removed` went into its neighbour `kept`.
///
/// The link of `removed` at that moment is Simplified::link(collapse): counter-clockwise seen from outside, closed for
/// a vertex inside, an open chain (border neighbour first and last) for one on the border. The faces around `removed`
/// were (removed, link[j], link[j + 1]); afterwards those without `kept` were (kept, link[j], link[j + 1]). Replacing
/// these by those, last collapse first, restores the finer meshes.
struct Collapse {
    std::uint32_t removed, kept;
    std::uint32_t first, count;  ///< of `links`
    bool closed;
};

struct Simplified {
    std::vector<Face> faces;          ///< over the vertices of the fine mesh
    std::vector<Collapse> collapses;  ///< in the order they were made
    std::vector<std::uint32_t> links;

    [[nodiscard]] std::span<const std::uint32_t> link(const Collapse& c) const {
        return std::span(links).subspan(c.first, c.count);
    }
};

/// Simplifies by half-edge collapses in order of quadric error [Garland, Heckbert 1997] until at most `target_faces`
/// remain or no collapse is allowed. A collapse must keep the link condition [Dey, Edelsbrunner, Guha, Nekhayev 1999],
/// so that genus, borders and manifoldness stay; it must not turn a face by more than `least_cosine` nor make it a
/// sliver: where what is left to collapse would cost much, slivers are allowed, and where that is not enough the mesh
/// keeps more faces than `target_faces` rather than its limbs. Border vertices move along their border only.
///
/// @param mesh  an oriented manifold without repeated edges (as repair() returns it); attributes are ignored
/// @throws model::Error kInterrupted
/// Deterministic (ties go to the lower vertex), single-threaded, about 2 microseconds a collapse.
[[nodiscard]] Simplified simplify(const TriMesh& mesh, std::size_t target_faces, const SimplifyOptions& options,
                                  const model::Progress& progress);

/// The vertices that `faces` name, numbered from 0 in their old order.
struct CompactMesh {
    TriMesh mesh;                         ///< positions and faces only
    std::vector<std::uint32_t> original;  ///< per vertex of `mesh`
};
[[nodiscard]] CompactMesh compact(std::span<const Vec3d> positions, std::span<const Face> faces);

}  // namespace dgm::bake
