// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/mesh_files.cpp
#include "export/mesh_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "export/chart_mesh.h"
#include "export/chart_pictures.h"
#include "export/gltf_file.h"
#include "export/level_of_detail.h"
#include "export/map_stamp.h"
#include "files/whole_file.h"
#include "geometry/metrics/reconstruction.h"
#include "image/image.h"
#include "mesh/mesh_writer.h"
#include "model/codes.h"

namespace dgm::exporter {
namespace {
using formats::Image;
using model::MapSet;
using model::TriMesh;
using model::Vec2d;
using std::filesystem::path;

/// The charts as one mesh, material k and object k those of chart k.
struct MergedCharts {
    TriMesh mesh;
    std::vector<ChartPictures> pictures;  ///< of one size a chart
    std::vector<formats::ObjObject> objects;
};

std::vector<std::vector<model::Face>> faces_for(const MapSet& maps, std::uint32_t stride, const path& output) {
    if (stride <= 1) return {};
    StagingFolder scratch(output);  // never published
    return faces_at_stride(maps, stride, scratch.add("level_of_detail.dgm"));
}

/// Adds a chart's vertices that have a face, its faces, and the attributes of their corners.
void append_chart(TriMesh& out, const ChartMesh& chart, const ChartPictures& pictures, std::uint32_t material,
                  std::array<std::uint32_t, 2> grid, bool normals) {
    const std::vector<std::uint32_t> used = named_vertices(chart.faces, chart.positions.size());
    if (out.positions.size() + used.size() > std::numeric_limits<std::uint32_t>::max())
        throw model::Error(model::codes::kTooLarge, "the charts together have more than 2^32 vertices");
    const auto base = static_cast<std::uint32_t>(out.positions.size());
    for (const std::uint32_t v : used) out.positions.push_back(chart.positions[v]);
    for (model::Face face : renumbered(chart.faces, used)) {
        for (std::uint32_t& v : face) v += base;
        out.faces.push_back(face);
        out.face_materials.push_back(material);
    }
    const Image* picture = !pictures.colour.pixels.empty() ? &pictures.colour
                           : pictures.normal_map           ? &*pictures.normal_map
                                                           : nullptr;
    const std::uint32_t across = picture != nullptr ? picture->width : grid[1];
    const std::uint32_t down = picture != nullptr ? picture->height : grid[0];
    for (const model::Face& face : chart.faces)
        for (const std::uint32_t v : face) {
            if (normals) out.corner_normals.push_back(chart.normals[v]);
            const Vec2d at = place_in_picture(chart.uvs[v], across, down);
            out.corner_uvs.push_back({at.x, 1 - at.y});  // v up, as in OBJ
        }
}

/// Of all samples: those of border samples are a layer of their own, which a file may lack.
bool has_normals(const model::Chart& chart) {
    const model::Layer* border = chart.find("border_geometry");
    const bool has_border = border != nullptr && border->shape[0] > 0;
    return chart.find("normal") != nullptr && (!has_border || chart.find("border_normal") != nullptr);
}

MergedCharts merged_charts(const MapSet& maps, const std::vector<std::string>& names, const path& output,
                           const ExportOptions& options) {
    const std::vector<std::vector<model::Face>> coarse = faces_for(maps, options.lods[0], output);
    const bool normals = std::all_of(maps.charts.begin(), maps.charts.end(), has_normals);
    MergedCharts out;
    for (std::uint32_t k = 0; k < maps.charts.size(); ++k) {
        const model::Chart& chart = maps.charts[k];
        const bake::Reconstruction surface = bake::reconstruct(chart);
        const ChartMesh mesh = chart_mesh(surface, {}, coarse.empty() ? nullptr : &coarse[k]);
        ChartPictures& pictures = out.pictures.emplace_back(chart_pictures(chart, surface, mesh, options.power_of_two));
        share_size(pictures);
        out.objects.push_back({names[k], out.mesh.faces.size()});
        append_chart(out.mesh, mesh, pictures, k, {chart.rows, chart.cols}, normals);
    }
    return out;
}

/// "robe_texture.png", or "robe_chart1_texture.png" if there are several charts.
path picture_name(const path& output, const MapSet& maps, const std::string& chart, const char* what) {
    return output.stem().string() + chart.substr(asset_name(maps).size()) + "_" + what + ".png";
}

/// Pictures stand beside the mesh; a mesh without any has no materials at all.
void write_obj_files(const MapSet& maps, const std::vector<std::string>& names, const path& output,
                     const ExportOptions& options, StagingFolder& staging) {
    MergedCharts charts = merged_charts(maps, names, output, options);
    bool with_mtl = false;
    for (std::size_t k = 0; k < names.size(); ++k) {
        model::Material& material = charts.mesh.materials.emplace_back();
        material.name = names[k];
        const ChartPictures& pictures = charts.pictures[k];
        if (!pictures.colour.pixels.empty()) {
            material.diffuse_map.path = picture_name(output, maps, names[k], "texture");
            formats::write_png(staging.add(material.diffuse_map.path), pictures.colour);
        }
        if (pictures.normal_map) {
            material.bump_map.path = picture_name(output, maps, names[k], "normal");
            material.bump_is_normal_map = true;
            formats::write_png(staging.add(material.bump_map.path), *pictures.normal_map);
        }
        with_mtl = with_mtl || !material.diffuse_map.empty() || !material.bump_map.empty();
    }
    if (!with_mtl) charts.mesh.materials.clear(), charts.mesh.face_materials.clear();
    formats::ObjWriteOptions how;
    how.write_mtl = with_mtl;
    how.objects = std::move(charts.objects);
    how.comment = stamp_comment(map_stamp(maps, mesh_settings(options)));
    if (with_mtl) static_cast<void>(staging.add(path(output.stem()).concat(".mtl")));
    formats::write_obj(staging.add(output.filename()), charts.mesh, how);
}

/// The texture's colour at each corner.
void add_colours(MergedCharts& charts) {
    TriMesh& mesh = charts.mesh;
    mesh.corner_colours.reserve(3 * mesh.faces.size());
    for (std::size_t c = 0; c < 3 * mesh.faces.size(); ++c) {
        const Image& image = charts.pictures[mesh.face_materials[c / 3]].colour;
        const auto texel = [](double t, std::uint32_t side) {
            return static_cast<std::uint32_t>(std::clamp(std::floor(t * side), 0.0, side - 1.0));
        };
        mesh.corner_colours.push_back(
            image.at(texel(mesh.corner_uvs[c].x, image.width), texel(1 - mesh.corner_uvs[c].y, image.height)));
    }
}

/// A PLY has one picture, if any: that of an only chart, the same as an OBJ beside it has, whose normal map may ask for
/// another size.
void write_ply_file(const MapSet& maps, const std::vector<std::string>& names, const path& output,
                    const ExportOptions& options, StagingFolder& staging) {
    MergedCharts charts = merged_charts(maps, names, output, options);
    const bool textured = std::all_of(charts.pictures.begin(), charts.pictures.end(),
                                      [](const ChartPictures& p) { return !p.colour.pixels.empty(); });
    formats::PlyWriteOptions how;
    if (textured) add_colours(charts);
    if (textured && charts.pictures.size() == 1) {
        how.texture = picture_name(output, maps, names[0], "texture").string();
        formats::write_png(staging.add(how.texture), charts.pictures[0].colour);
    }
    how.doubles = std::any_of(maps.charts.begin(), maps.charts.end(), [](const model::Chart& c) {
        return c.offset != std::array<double, 3>{0, 0, 0} || c.scale != std::array<double, 3>{1, 1, 1};
    });
    how.comment = stamp_comment(map_stamp(maps, mesh_settings(options)));
    formats::write_ply(staging.add(output.filename()), charts.mesh, how);
}

void write_glb_file(const MapSet& maps, const std::vector<std::string>& names, const path& output,
                    const ExportOptions& options, StagingFolder& staging) {
    GlbOptions how;
    how.names = names;
    for (const std::uint32_t stride : options.lods) how.levels.push_back({stride, faces_for(maps, stride, output)});
    how.lod_mode = options.lod_mode;
    how.up = options.up;
    how.quantize = options.quantize;
    how.compress = options.compress;
    how.power_of_two = options.power_of_two;
    how.stamp = map_stamp(maps, mesh_settings(options));
    formats::write_whole_file(staging.add(output.filename()), encode_glb(maps, how), output);
}
}  // namespace

std::string mesh_settings(const ExportOptions& options) {
    std::string out;
    if (options.chart) out += fmt::format("chart={};", *options.chart);
    if (options.lods != std::vector<std::uint32_t>{1}) {
        for (const std::uint32_t lod : options.lods) out += fmt::format("lod={};", lod);
        if (options.lods.size() > 1) out += options.lod_mode == LodMode::kMsft ? "msft;" : "nodes;";
    }
    if (options.up == render::UpAxis::kZ) out += "up=z;";
    if (options.quantize) out += "quantize;";
    if (options.compress) out += "compress;";
    if (options.power_of_two) out += "power_of_two;";
    return out;
}

void write_mesh_files(const MapSet& maps, const std::vector<std::string>& names, const path& output,
                      const ExportOptions& options, StagingFolder& staging) {
    const std::string extension = lower_extension(output);
    if (extension == ".obj")
        write_obj_files(maps, names, output, options, staging);
    else if (extension == ".ply")
        write_ply_file(maps, names, output, options, staging);
    else
        write_glb_file(maps, names, output, options, staging);
}

}  // namespace dgm::exporter
