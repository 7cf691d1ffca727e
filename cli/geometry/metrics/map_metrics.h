// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/metrics/map_metrics.h
// Distortion and validity of a map from a disk to the plane (docs/design.md section 7).
#pragma once
#include <cstdint>
#include <span>

#include "model/tri_mesh.h"
#include "model/vec.h"

namespace dgm::bake {

struct MapMetrics {
    double stretch_l2 = 0;    ///< [Sander 2001], normalised so that 1 is isometric up to scale
    double stretch_linf = 0;  ///< worst larger singular value, same normalisation
    double symmetric_dirichlet =
        0;                    ///< mean of (s1^2 + s2^2 + s1^-2 + s2^-2) / 4 after the best global scale; 1 = isometric
    double angle = 0;         ///< mean of (s1/s2 + s2/s1) / 2, by surface area; 1 = conformal
    double area = 0;          ///< mean of (r + 1/r) / 2, r = map area / surface area after the best scale; 1 = authalic
    std::uint64_t flips = 0;  ///< faces with negative orientation, exact predicate
    std::uint64_t degenerate = 0;  ///< faces with zero orientation, exact predicate
    std::uint64_t not_finite = 0;  ///< vertices with a NaN or infinite coordinate
};

/// Flipped and degenerate faces are counted and left out of the norms.
[[nodiscard]] MapMetrics measure_map(std::span<const model::Vec3d> positions, std::span<const model::Face> faces,
                                     std::span<const model::Vec2d> uv);

/// Sign of the area of (a, b, c): +1 counter-clockwise, -1 clockwise, 0 collinear. Exact for finite input that does not
/// over- or underflow in its products [Shewchuk 1997].
[[nodiscard]] int orient2d(model::Vec2d a, model::Vec2d b, model::Vec2d c);

struct Topology {
    std::uint64_t components = 0, boundary_loops = 0;
    std::int64_t genus = 0;  ///< handles, summed over the components; where not oriented, crosscaps: 1 for a
                             ///< projective plane or a Moebius strip, 2 for a Klein bottle; 0 unless manifold
    bool manifold = false;   ///< every edge has one or two faces, every vertex one fan
    bool oriented = false;   ///< neighbours agree in winding
    std::uint64_t degenerate_faces = 0;  ///< faces that name a vertex twice or out of range; not part of the rest
    friend bool operator==(const Topology&, const Topology&) = default;
};
/// Vertices that no face names do not count. Components are joined through shared vertices.
[[nodiscard]] Topology measure_topology(std::size_t vertex_count, std::span<const model::Face> faces);
/// Of a component as repair() makes it, with the sides joined along which it was opened to have an inside.
[[nodiscard]] Topology measure_topology(const model::TriMesh& component);

}  // namespace dgm::bake
