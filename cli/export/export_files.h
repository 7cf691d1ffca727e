// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/export_files.h
// Writes a MapSet for dgm-export: other containers, meshes, pictures.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "mesh/mesh_reader.h"
#include "model/map_set.h"
#include "render/camera.h"

namespace dgm::exporter {

struct ExportOptions {
    std::optional<std::uint32_t> chart;  ///< only this one; default all
    std::string layer;                   ///< PNG: this layer's picture
    bool sheet = false;                  ///< PNG: all layers of each chart
    std::filesystem::path source;        ///< PNG: compare with this mesh
    /// Reads `source`; none: formats::read_mesh.
    std::function<formats::ImportedMesh(const std::filesystem::path&)> read_mesh;
    std::optional<std::uint32_t> width, height;  ///< PNG
    std::optional<render::View> view;            ///< PNG
    render::UpAxis up = render::UpAxis::kY;      ///< PNG, GLB: of the source
    std::uint32_t lod = 1;                       ///< OBJ, PLY, GLB: stride in quads, see faces_at_stride()
    bool multipart = false;                      ///< EXR: one part a layer
};

/// Reads a .dgm or an .exr, by content. @throws model::Error as formats::read_dgm and read_exr
[[nodiscard]] model::MapSet read_maps(const std::filesystem::path& path);

/// Writes `maps` to `output` in the form its extension names: dgm, exr, obj (with MTL and the textures as
/// STEM_chart<k>_texture.png), ply (vertex colours from the texture), glb (encode_glb()) or png. Every file is written
/// aside, in a folder beside the output, and moved into place when all of them are complete: on an error the old files
/// are untouched and nothing new is left. Same maps and options, same bytes.
///
/// `warn` hears of textures of the source that cannot be read.
/// @throws model::Error kUsage for an unknown extension, options that do not go with it, or a chart that does not
///         exist; kUnsupported for gltf; and whatever the readers, writers and pictures throw
void export_maps(const model::MapSet& maps, const std::filesystem::path& output, const ExportOptions& options,
                 const std::function<void(const std::string&)>& warn);

}  // namespace dgm::exporter
