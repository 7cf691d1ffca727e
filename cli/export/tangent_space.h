// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/tangent_space.h
// Tangents and a tangent-space normal map for one chart, as glTF and most engines expect them.
//
// The basis at a vertex is (T, B, N): N the stored normal, T along increasing texture x (columns, v), B = N x T, which
// points along decreasing texture y (rows, u), since charts wind counter-clockwise in (u, v) and pictures have row 0 at
// the top. So the handedness is +1 everywhere, and green points up in the picture ("OpenGL" normal maps).
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "export/chart_mesh.h"
#include "image/image.h"
#include "model/map_set.h"
#include "model/vec.h"

namespace dgm::exporter {

/// Unit tangents of the vertices, perpendicular to the normals, by the rule of [Mikkelsen 2008], that is MikkTSpace:
/// each face's direction of growing v, projected into the vertex's normal plane and made unit, weighted by the face's
/// angle there as seen in that plane. Vertices are the mesh's own (MikkTSpace welds equal ones first, and seam copies
/// differ in their texture coordinates). Where the sum vanishes, and at vertices without a face, some direction in the
/// plane.
/// @pre normals and uvs have one entry a vertex
[[nodiscard]] std::vector<model::Vec3d> vertex_tangents(const ChartMesh& mesh);

/// The normal map of the layer `bump`, at the layer's resolution: each texel's shading normal of formats/SPEC.md 3.6
/// (the blend of stored and fine normal that the file's `shading` asks for) in the basis that a renderer interpolates
/// over `mesh.faces`: N and T made unit, B = N x T. So on coarser faces the map brings the full grid's normals back. A
/// component c is stored as 127.5 + 127.5 c rounded; texels without a face, and on border strips, are (128, 128, 255).
/// Linear data: not to be read as sRGB, not to be compressed as colour.
/// @return nothing if the chart has no bump or no normals
/// @throws model::Error kBadLayerShape, kTooLarge
[[nodiscard]] std::optional<formats::Image> tangent_normal_map(const model::Chart& chart,
                                                               const bake::Reconstruction& surface,
                                                               const ChartMesh& mesh,
                                                               std::span<const model::Vec3d> tangents);

}  // namespace dgm::exporter
