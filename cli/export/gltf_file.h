// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/gltf_file.h
// glTF 2.0 in its binary form (.glb): one file with everything in it, for engines, viewers and Blender.
#pragma once
#include <cstddef>
#include <vector>

#include "model/map_set.h"
#include "model/vec.h"
#include "render/camera.h"

namespace dgm::exporter {

/// The bytes of a .glb: a root node named after the source, below it for each chart a node "chart<k>" with a mesh of
/// one primitive.
///
/// POSITION f32, the chart's local coordinates; the node's translation is the chart's offset. NORMAL from the layer
/// `normal`. TEXCOORD_0 with corner samples on the middles of corner texels of the base colour texture; TEXCOORD_1 the
/// same for the normal map where that has another size. TANGENT with a normal map (tangent_space.h). Indices are u16 up
/// to 65535 vertices, else u32. Vertices are the samples that have a face, in their order; seam copies are vertices of
/// their own with equal positions and normals. Textures are PNG, clamped to the edge. metallicFactor 0, roughnessFactor
/// 0.8; doubleSided where the chart has an open border. The texture's alpha is kept but not used (alphaMode OPAQUE).
///
/// glTF means metres and y up; the source's units and axes are kept as they are, but with `up` = kZ the root's matrix
/// turns z up into y up.
///
/// @param coarse  faces of each chart, see faces_at_stride(); empty: all of them
/// Same input, same bytes. @throws model::Error as bake::reconstruct and tangent_normal_map; kNotFinite for a vertex
/// that f32 cannot hold; kTooLarge beyond 4 GiB
[[nodiscard]] std::vector<std::byte> encode_glb(const model::MapSet& maps,
                                                const std::vector<std::vector<model::Face>>& coarse, render::UpAxis up);

}  // namespace dgm::exporter
