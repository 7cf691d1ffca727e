// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/metrics/reconstruction.h
// The surface that a chart's layers describe, as the runtime would draw it. Every error is measured on it.
#pragma once
#include "model/map_set.h"
#include "model/tri_mesh.h"

namespace dgm::bake {

struct Reconstruction {
    model::TriMesh mesh;                    ///< source frame (offset and scale applied), seam copies kept apart
    std::vector<std::uint32_t> weld;        ///< per vertex: its class representative (seam table), else itself
    std::vector<model::Face> welded_faces;  ///< mesh.faces through `weld`
    std::vector<std::uint8_t> reversed;     ///< per vertex: 1 where its faces wind against those of its representative
                                            ///< (layer `reversed`); empty if there is no such layer
    double seam_gap = 0;                    ///< largest distance between copies of a class; must be exactly 0
};

/// Faces beside a seam with reversed copies (metrics/turned_faces.h); empty if there is none.
[[nodiscard]] std::vector<char> faces_beside_reversed(const Reconstruction& surface);

/// Are attributes of corners filled in? Positions and faces alone take a third of the time.
enum class Corners { kFill, kSkip };

/// Vertices are grid samples (i*n+j), then border samples (m*n+b). Faces are the quads' triangles (split by
/// `diagonals`, quads with an unmasked corner left out), then `border_faces`. Samples off the surface are dropped from
/// faces, not renumbered. With Corners::kFill, corner_normals are filled if the layer `normal` is there, corner_uvs
/// with the chart's (v, u).
/// @throws model::Error kMissingLayer without geometry, kBadLayerShape, kBadValue (a border face beyond the samples),
/// kBadSeamTable; place is the layer's name
[[nodiscard]] Reconstruction reconstruct(const model::Chart& chart, Corners fill = Corners::kFill);

}  // namespace dgm::bake
