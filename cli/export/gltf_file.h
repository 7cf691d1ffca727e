// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/gltf_file.h
// glTF 2.0 in its binary form (.glb): one file with everything in it, for engines, viewers and Blender.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "model/map_set.h"
#include "model/vec.h"
#include "render/camera.h"

namespace dgm::exporter {

/// One level of detail of all charts.
struct GlbLevel {
    std::uint32_t stride = 1;                     ///< see faces_at_stride()
    std::vector<std::vector<model::Face>> faces;  ///< of each chart; empty: all of them
};

/// Where further levels go. kNodes: nodes beside the first level's, called NAME_lod<stride>. kMsft: the same nodes, in
/// no scene but named by MSFT_lod of the first level's, so that a client that does not know the extension draws the
/// finest level alone.
enum class LodMode { kNodes, kMsft };

struct GlbOptions {
    std::vector<std::string> names;  ///< of the charts, as chart_names() gives them; empty: those
    std::vector<GlbLevel> levels;    ///< from fine to coarse; empty: one with all faces
    LodMode lod_mode = LodMode::kMsft;
    render::UpAxis up = render::UpAxis::kY;  ///< of the source
    bool quantize = false;                   ///< KHR_mesh_quantization
    bool compress = false;                   ///< EXT_meshopt_compression
    bool power_of_two = false;               ///< sides of all pictures, see chart_pictures.h
    std::string stamp;                       ///< asset.extras.map; empty: none
};

/// The bytes of a .glb. Each chart is a node with a mesh of one primitive; node, mesh and material have its name. Of
/// several charts the nodes stand below a root node named after the source.
///
/// POSITION f32, the chart's local coordinates; the node's translation is the chart's offset. NORMAL from the layer
/// `normal`. TEXCOORD_0 with corner samples on the middles of corner texels of the base colour texture; TEXCOORD_1 the
/// same for the normal map where that has another size. TANGENT with a normal map (tangent_space.h). Indices are u16 up
/// to 65535 vertices, else u32. Vertices are the samples that have a face in any level, in their order; seam copies are
/// vertices of their own with equal positions and normals. Textures are PNG, clamped to the edge. metallicFactor 0,
/// roughnessFactor 0.8; doubleSided where the chart has an open border. The texture's alpha is kept but not used
/// (alphaMode OPAQUE).
///
/// Levels of a chart share vertices and material; the normal map is that of the first level. Under MSFT_lod the node's
/// extras.MSFT_screencoverage asks for the finest level while a block of the next one would take more than four of 1080
/// lines on the screen.
///
/// Quantized, positions are u16 shares of the chart's longest side, within 1/131070 of it, and the node scales them
/// back; normals and tangents are i8, texture coordinates u16, all normalized.
///
/// glTF means metres and y up; the source's units and axes are kept as they are, but with `up` = kZ the matrix of the
/// topmost node turns z up into y up.
///
/// Same input, same bytes. @throws model::Error as bake::reconstruct and tangent_normal_map; kNotFinite for a vertex
/// that f32 cannot hold; kTooLarge beyond 4 GiB
[[nodiscard]] std::vector<std::byte> encode_glb(const model::MapSet& maps, const GlbOptions& options = {});

}  // namespace dgm::exporter
