// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/gltf_file.cpp
//
// [glTF 2.0] The Khronos Group. glTF 2.0 Specification, version 2.0.1 = ISO/IEC 12113:2022.
// [MSFT_lod] Microsoft. MSFT_lod: levels of detail, a vendor extension of glTF 2.0.
#include "export/gltf_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>

#include "export/chart_mesh.h"
#include "export/chart_pictures.h"
#include "export/glb_buffer.h"
#include "export/glb_vertices.h"
#include "export/tangent_space.h"
#include "geometry/metrics/reconstruction.h"
#include "image/image.h"
#include "model/codes.h"

namespace dgm::exporter {
namespace {
using Json = GlbBuffer::Json;
using model::Chart;
using model::Face;
using model::Vec3d;

// Names of glTF's numbers, section 5.
constexpr int kLinear = 9729, kLinearMipmapLinear = 9987, kClampToEdge = 33071, kTriangles = 4;
constexpr double kRoughness = 0.8;             // cloth and skin more than polish; the map says nothing about it
constexpr double kCoarsestBlock = 4.0 / 1080;  // of the screen's height, until a finer level is asked for

/// The faces of a chart in each level, and the vertices that any of them names.
struct ChartLevels {
    std::vector<std::vector<Face>> faces;
    std::vector<std::uint32_t> used;
};

ChartLevels levels_of(const ChartMesh& mesh, std::size_t k, const std::vector<GlbLevel>& levels) {
    ChartLevels out;
    out.faces.push_back(mesh.faces);
    for (std::size_t l = 1; l < levels.size(); ++l) out.faces.push_back(levels[l].faces[k]);
    std::vector<Face> all;
    for (const std::vector<Face>& faces : out.faces) {
        if (faces.empty()) throw model::Error(model::codes::kBadValue, "chart " + std::to_string(k) + " has no faces");
        all.insert(all.end(), faces.begin(), faces.end());
    }
    out.used = named_vertices(all, mesh.positions.size());
    for (std::vector<Face>& faces : out.faces) faces = renumbered(std::move(faces), out.used);
    return out;
}

/// A coarser level may use samples that the first one does not: their tangents are those of the first level that does.
void complete_tangents(std::vector<Vec3d>& tangents, ChartMesh mesh, std::size_t k,
                       const std::vector<GlbLevel>& levels) {
    std::vector<char> done(tangents.size(), 0);
    for (std::size_t l = 0; l < levels.size(); ++l) {
        std::vector<Vec3d> own;
        if (l > 0) {
            mesh.faces = levels[l].faces[k];
            own = vertex_tangents(mesh);
        }
        for (const std::uint32_t v : named_vertices(mesh.faces, tangents.size())) {
            if (done[v] == 0 && l > 0) tangents[v] = own[v];
            done[v] = 1;
        }
    }
}

class Document {
 public:
    Document(const model::MapSet& maps, const GlbOptions& options)
        : maps_(maps),
          options_(options),
          names_(options.names.empty() ? chart_names(maps) : options.names),
          buffer_(options.compress) {
        root_["asset"] = {{"version", "2.0"}, {"generator", "dgm-export " DGM_VERSION}};
        if (!options.stamp.empty()) root_["asset"]["extras"] = Json{{"map", options.stamp}};
        root_["scene"] = 0;
        root_["scenes"] = Json::array({Json{{"nodes", Json::array()}}});
        root_["nodes"] = Json::array();
        if (maps.charts.size() > 1) {
            Json top{{"name", asset_name(maps)}, {"children", Json::array()}};
            if (options.up == render::UpAxis::kZ) set_matrix(top, {});
            add_node(std::move(top), root_["scenes"][0]["nodes"]);
        }
        for (const char* list : {"meshes", "materials", "textures", "images"}) root_[list] = Json::array();
        if (options.quantize) require("KHR_mesh_quantization");
        for (std::size_t k = 0; k < maps.charts.size(); ++k) add_chart(k);
    }

    /// @throws model::Error kTooLarge
    [[nodiscard]] std::vector<std::byte> encode() {
        if (root_["textures"].empty())
            root_.erase("textures"), root_.erase("images");  // glTF has no empty lists
        else
            root_["samplers"] = Json::array({Json{{"magFilter", kLinear},
                                                  {"minFilter", kLinearMipmapLinear},
                                                  {"wrapS", kClampToEdge},
                                                  {"wrapT", kClampToEdge}}});
        buffer_.describe(root_);
        std::string text = root_.dump(-1, ' ', false, Json::error_handler_t::replace);
        text.resize((text.size() + 3) / 4 * 4, ' ');
        const std::size_t binary = (buffer_.bytes().size() + 3) / 4 * 4, total = 12 + 8 + text.size() + 8 + binary;
        if (total > std::numeric_limits<std::uint32_t>::max())
            throw model::Error(model::codes::kTooLarge, "a .glb holds at most 4 GiB")
                .with_hint("use --lod 2, or export the charts one by one with --chart");

        std::vector<std::byte> out;
        out.reserve(total);
        const auto word = [&](std::size_t value) {
            for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::byte>(value >> shift & 0xff));
        };
        word(0x46546c67), word(2), word(total);  // "glTF", version
        word(text.size()), word(0x4e4f534a);     // "JSON"
        const auto json = std::as_bytes(std::span(text));
        out.insert(out.end(), json.begin(), json.end());
        word(binary), word(0x004e4942);  // "BIN"
        out.insert(out.end(), buffer_.bytes().begin(), buffer_.bytes().end());
        out.resize(total);
        return out;
    }

 private:
    void require(const char* extension) {
        for (const char* list : {"extensionsUsed", "extensionsRequired"}) root_[list].push_back(extension);
    }
    std::size_t add_node(Json node, Json& list) {
        const std::size_t number = root_["nodes"].size();
        list.push_back(number);
        root_["nodes"].push_back(std::move(node));
        return number;
    }

    /// The matrix, by columns, that turns z up into y up and applies `frame` before that.
    static void set_matrix(Json& node, const GlbFrame& frame) {
        const double s = frame.scale;
        const Vec3d& t = frame.translation;
        // + 0.0: no "-0.0" in the text.
        node["matrix"] = {s, 0, 0, 0, 0, 0, -s, 0, 0, s, 0, 0, t.x, t.z, -t.y + 0.0, 1};
    }
    void place(Json& node, const GlbFrame& frame) const {
        if (maps_.charts.size() == 1 && options_.up == render::UpAxis::kZ) return set_matrix(node, frame);
        const Vec3d& t = frame.translation;
        if (!(t == Vec3d{})) node["translation"] = {t.x, t.y, t.z};
        if (frame.scale != 1) node["scale"] = {frame.scale, frame.scale, frame.scale};
    }

    void add_chart(std::size_t k) {
        const Chart& chart = maps_.charts[k];
        const bake::Reconstruction surface = bake::reconstruct(chart);
        GlbFrame frame;
        frame.translation = {chart.offset[0], chart.offset[1], chart.offset[2]};
        const bool coarse = !options_.levels.empty() && !options_.levels[0].faces.empty();
        const ChartMesh mesh = chart_mesh(surface, frame.translation, coarse ? &options_.levels[0].faces[k] : nullptr);
        const ChartLevels levels = levels_of(mesh, k, options_.levels);

        Json attributes, material{{"name", names_[k]}}, pbr;
        GlbVertices vertices(buffer_, mesh, levels.used, options_.quantize);
        attributes["POSITION"] = vertices.add_positions(frame);
        if (!mesh.normals.empty()) attributes["NORMAL"] = vertices.add_normals();
        if (!mesh.uvs.empty()) {
            ChartPictures pictures = chart_pictures(chart, surface, mesh, options_.power_of_two);
            if (pictures.normal_map) complete_tangents(pictures.tangents, mesh, k, options_.levels);
            add_textures(chart, pictures, vertices, attributes, material, pbr);
        }
        pbr["metallicFactor"] = 0;
        pbr["roughnessFactor"] = kRoughness;
        material["pbrMetallicRoughness"] = std::move(pbr);
        if (is_open(surface)) material["doubleSided"] = true;
        root_["materials"].push_back(std::move(material));
        add_levels(k, frame, levels, attributes);
    }

    void add_levels(std::size_t k, const GlbFrame& frame, const ChartLevels& levels, const Json& attributes) {
        std::vector<Json> nodes;
        for (std::size_t l = 0; l < levels.faces.size(); ++l) {
            const std::string name =
                l == 0 ? names_[k] : names_[k] + "_lod" + std::to_string(options_.levels[l].stride);
            const std::size_t indices = buffer_.add_indices(levels.faces[l], levels.used.size());
            nodes.push_back(Json{{"name", name}, {"mesh", root_["meshes"].size()}});
            place(nodes.back(), frame);
            root_["meshes"].push_back(
                Json{{"name", name},
                     {"primitives",
                      Json::array({Json{
                          {"attributes", attributes}, {"indices", indices}, {"material", k}, {"mode", kTriangles}}})}});
        }
        const bool msft = nodes.size() > 1 && options_.lod_mode == LodMode::kMsft;
        Json hidden = Json::array();
        Json& parent = maps_.charts.size() > 1 ? root_["nodes"][0]["children"] : root_["scenes"][0]["nodes"];
        Json shown = std::move(parent);  // adding nodes moves the list that it stands in
        const std::size_t first = add_node(std::move(nodes[0]), shown);
        for (std::size_t l = 1; l < nodes.size(); ++l) add_node(std::move(nodes[l]), msft ? hidden : shown);
        (maps_.charts.size() > 1 ? root_["nodes"][0]["children"] : root_["scenes"][0]["nodes"]) = std::move(shown);
        if (!msft) return;
        root_["nodes"][first]["extensions"]["MSFT_lod"]["ids"] = std::move(hidden);
        root_["nodes"][first]["extras"]["MSFT_screencoverage"] = coverages(maps_.charts[k]);
        Json& used = root_["extensionsUsed"];
        if (std::find(used.begin(), used.end(), "MSFT_lod") == used.end()) used.push_back("MSFT_lod");
    }

    /// The least share of the screen's height for each level. The last one is drawn however small it is.
    [[nodiscard]] Json coverages(const Chart& chart) const {
        const double quads = std::max(chart.rows, chart.cols) - 1.0;
        Json out = Json::array();
        for (std::size_t l = 1; l < options_.levels.size(); ++l)
            out.push_back(std::min(1.0, kCoarsestBlock * quads / options_.levels[l].stride));
        out.push_back(0.0);
        return out;
    }

    std::size_t add_texture(const formats::Image& picture, const std::string& name) {
        const std::size_t view = buffer_.add_view(formats::encode_png(picture));
        root_["images"].push_back(Json{{"name", name}, {"mimeType", "image/png"}, {"bufferView", view}});
        root_["textures"].push_back(Json{{"sampler", 0}, {"source", root_["images"].size() - 1}});
        return root_["textures"].size() - 1;
    }
    void add_textures(const Chart& chart, const ChartPictures& pictures, GlbVertices& vertices, Json& attributes,
                      Json& material, Json& pbr) {
        const std::string name = material["name"];
        const formats::Image& colour = pictures.colour;
        const std::optional<formats::Image>& normal_map = pictures.normal_map;
        std::uint32_t across = chart.cols, down = chart.rows;
        if (!colour.pixels.empty()) {
            across = colour.width;
            down = colour.height;
        } else if (normal_map) {
            across = normal_map->width;
            down = normal_map->height;
        }
        attributes["TEXCOORD_0"] = vertices.add_uvs(across, down);
        if (!colour.pixels.empty()) pbr["baseColorTexture"] = {{"index", add_texture(colour, name + " colour")}};
        if (!normal_map) return;
        Json texture{{"index", add_texture(*normal_map, name + " normal map")}};
        if (normal_map->width != across || normal_map->height != down) {
            attributes["TEXCOORD_1"] = vertices.add_uvs(normal_map->width, normal_map->height);
            texture["texCoord"] = 1;
        }
        attributes["TANGENT"] = vertices.add_tangents(pictures.tangents);
        material["normalTexture"] = std::move(texture);
    }

    const model::MapSet& maps_;
    const GlbOptions& options_;
    std::vector<std::string> names_;
    Json root_ = Json::object();
    GlbBuffer buffer_;
};
}  // namespace

std::vector<std::byte> encode_glb(const model::MapSet& maps, const GlbOptions& options) {
    return Document(maps, options).encode();
}

}  // namespace dgm::exporter
