// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/export_files.h
// Writes a MapSet for dgm-export: other containers, meshes, pictures.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "export/gltf_file.h"
#include "mesh/mesh_reader.h"
#include "model/map_set.h"
#include "render/camera.h"

namespace dgm::exporter {

struct ExportOptions {
    std::optional<std::uint32_t> chart;  ///< only this one; default all
    std::string layer;                   ///< PNG: this layer's picture
    bool sheet = false;                  ///< PNG: all layers of each chart
    std::filesystem::path source;        ///< PNG, HTML: compare with this mesh
    /// Reads `source`; none: formats::read_mesh.
    std::function<formats::ImportedMesh(const std::filesystem::path&)> read_mesh;
    std::optional<std::uint32_t> width, height;  ///< PNG
    std::optional<render::View> view;            ///< PNG
    render::UpAxis up = render::UpAxis::kY;      ///< PNG, GLB, HTML: of the source
    std::vector<std::uint32_t> lods{1};        ///< OBJ, PLY, GLB: stride in quads, see faces_at_stride(); GLB: several
    LodMode lod_mode = LodMode::kMsft;         ///< GLB: of several levels
    bool quantize = false, compress = false;   ///< GLB, see GlbOptions
    bool power_of_two = false;                 ///< OBJ, PLY, GLB: sides of pictures
    bool multipart = false;                    ///< EXR: one part a layer
    std::vector<std::filesystem::path> paths;  ///< HTML: recorded tool paths that the page plays
    bool cover = false;                        ///< HTML: the second map lies over the first one
    /// HTML: parses the report inside a map, null if it is none; none: read here.
    std::function<nlohmann::json(const std::string&)> read_report;
};

/// Reads a .dgm or an .exr, by content. @throws model::Error as formats::read_dgm and read_exr
[[nodiscard]] model::MapSet read_maps(const std::filesystem::path& path);

/// The kinds of output, as their extensions: ".obj", ".ply", ...
[[nodiscard]] const std::vector<std::string>& known_extensions();

/// The extension of `file` in lower case, with its dot.
[[nodiscard]] std::string lower_extension(const std::filesystem::path& file);

/// Writes `maps` to `output` in the form its extension names: dgm, exr, obj (an object a chart; an MTL, textures and
/// normal maps as STEM_texture.png and STEM_normal.png, or STEM_chart<k>_texture.png of several charts), ply (texture
/// coordinates, vertex colours from the texture, and the texture itself of an only chart), glb (encode_glb()), png or
/// html (a page to touch, see page/page_file.h).
/// Meshes hold the samples that have a face, and call charts as chart_names() does.
///
/// Every file is written aside, in a folder beside the output, and moved into place when all of them are complete: on
/// an error the old files are untouched and nothing new is left. Same maps and options, same bytes.
///
/// `warn` hears of textures of the source that cannot be read.
/// @throws model::Error kUsage for an unknown extension, options that do not go with it, or a chart that does not
///         exist; kUnsupported for gltf; and whatever the readers, writers and pictures throw
void export_maps(const model::MapSet& maps, const std::filesystem::path& output, const ExportOptions& options,
                 const std::function<void(const std::string&)>& warn);

/// A map of a page, and what it is called there.
struct NamedMaps {
    std::string name;
    model::MapSet maps;
};

/// Writes one page for several maps, or for none: maps are dropped on it then. @throws model::Error as export_maps
void export_page(const std::vector<NamedMaps>& maps, const std::filesystem::path& output, const ExportOptions& options);

}  // namespace dgm::exporter
