// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/gltf_file.cpp
//
// [glTF 2.0] The Khronos Group. glTF 2.0 Specification, version 2.0.1 = ISO/IEC 12113:2022.
#include "export/gltf_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>

#include "export/tangent_space.h"
#include "geometry/metrics/reconstruction.h"
#include "image/image.h"
#include "model/codes.h"
#include "render/chart_surface.h"

namespace dgm::exporter {
namespace {
using Json = nlohmann::ordered_json;
using model::Chart;
using model::Face;
using model::Vec2d;
using model::Vec3d;

// Names of glTF's numbers, section 5.
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr int kLinear = 9729, kLinearMipmapLinear = 9987, kClampToEdge = 33071, kTriangles = 4;
constexpr double kRoughness = 0.8;  // cloth and skin more than polish; the map says nothing about it

/// The binary chunk, and the buffer views and accessors that point into it.
class Buffer {
 public:
    Json views = Json::array(), accessors = Json::array();

    /// Views start at multiples of 4, which suits every component type.
    std::size_t add_view(std::span<const std::byte> data, int target) {
        bytes_.resize((bytes_.size() + 3) / 4 * 4);
        Json view{{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", data.size()}};
        if (target != 0) view["target"] = target;
        bytes_.insert(bytes_.end(), data.begin(), data.end());
        views.push_back(std::move(view));
        return views.size() - 1;
    }
    template <std::size_t N>
    std::size_t add_vertices(const std::vector<std::array<float, N>>& values) {
        constexpr std::array kTypes{"", "", "VEC2", "VEC3", "VEC4"};
        return add_accessor(add_view(std::as_bytes(std::span(values)), kArrayBuffer), kFloat, values.size(), kTypes[N]);
    }
    std::size_t add_indices(const std::vector<Face>& faces, std::size_t vertices) {
        // 65535 means "restart" and is no vertex.
        if (vertices > 65535)
            return add_accessor(add_view(std::as_bytes(std::span(faces)), kElementArrayBuffer), kUnsignedInt,
                                3 * faces.size(), "SCALAR");
        std::vector<std::uint16_t> narrow;
        narrow.reserve(3 * faces.size());
        for (const Face& face : faces)
            for (const std::uint32_t v : face) narrow.push_back(static_cast<std::uint16_t>(v));
        return add_accessor(add_view(std::as_bytes(std::span(narrow)), kElementArrayBuffer), kUnsignedShort,
                            narrow.size(), "SCALAR");
    }
    [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }

 private:
    std::size_t add_accessor(std::size_t view, int component, std::size_t count, const char* type) {
        accessors.push_back(Json{{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}});
        return accessors.size() - 1;
    }
    std::vector<std::byte> bytes_;
};

std::array<float, 3> floats(const Vec3d& p) {
    return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

/// Whether a face's edge has no other face: its border is no seam.
bool is_open(const bake::Reconstruction& surface) {
    std::vector<std::uint64_t> edges;
    edges.reserve(3 * surface.welded_faces.size());
    for (const Face& f : surface.welded_faces)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = f[k], b = f[(k + 1) % 3];
            edges.push_back((std::uint64_t{std::min(a, b)} << 32) | std::max(a, b));
        }
    std::sort(edges.begin(), edges.end());
    for (std::size_t k = 0; k < edges.size(); ++k)
        if ((k == 0 || edges[k - 1] != edges[k]) && (k + 1 == edges.size() || edges[k + 1] != edges[k])) return true;
    return false;
}

ChartMesh chart_mesh(const Chart& chart, const bake::Reconstruction& surface, const std::vector<Face>* coarse) {
    const model::TriMesh& full = surface.mesh;
    ChartMesh out;
    out.faces = coarse != nullptr ? *coarse : full.faces;
    const Vec3d offset{chart.offset[0], chart.offset[1], chart.offset[2]};
    out.positions.reserve(full.positions.size());
    for (const Vec3d& p : full.positions) out.positions.push_back(p - offset);
    if (!full.corner_normals.empty()) out.normals.assign(full.positions.size(), {0, 0, 1});
    if (!full.corner_uvs.empty()) out.uvs.resize(full.positions.size());
    for (std::size_t c = 0; c < 3 * full.faces.size(); ++c) {
        const std::uint32_t v = full.faces[c / 3][c % 3];
        if (!out.normals.empty()) out.normals[v] = full.corner_normals[c];
        if (!out.uvs.empty()) out.uvs[v] = {full.corner_uvs[c].y, full.corner_uvs[c].x};
    }
    return out;
}

/// The entries of `used`, in their order, as `convert` stores them.
template <class Out, class In, class Convert>
std::vector<Out> gathered(const std::vector<std::uint32_t>& used, const std::vector<In>& values, Convert convert) {
    std::vector<Out> out;
    out.reserve(used.size());
    for (const std::uint32_t v : used) out.push_back(convert(values[v]));
    return out;
}

class Document {
 public:
    Document(const model::MapSet& maps, render::UpAxis up) {
        root_["asset"] = {{"version", "2.0"}, {"generator", "dgm-export " DGM_VERSION}};
        root_["scene"] = 0;
        root_["scenes"] = Json::array({Json{{"nodes", {0}}}});
        const std::string stem = std::filesystem::path(maps.source_name).stem().string();
        Json top{{"name", stem.empty() ? "surface" : stem}, {"children", Json::array()}};
        if (up == render::UpAxis::kZ) top["matrix"] = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1};  // by columns
        root_["nodes"] = Json::array({top});
        for (const char* list : {"meshes", "materials", "textures", "images"}) root_[list] = Json::array();
    }

    void add_chart(const Chart& chart, const std::vector<Face>* coarse) {
        const std::size_t k = root_["meshes"].size();
        const std::string name = "chart" + std::to_string(k);
        const bake::Reconstruction surface = bake::reconstruct(chart);
        ChartMesh mesh = chart_mesh(chart, surface, coarse);
        if (mesh.faces.empty())
            throw model::Error(model::codes::kBadValue, "chart " + std::to_string(k) + " has no faces");
        const std::vector<std::uint32_t> used = number_vertices(mesh);

        Json attributes, material{{"name", name}}, pbr;
        attributes["POSITION"] = add_positions(used, mesh);
        if (!mesh.normals.empty())
            attributes["NORMAL"] = buffer_.add_vertices(gathered<std::array<float, 3>>(used, mesh.normals, floats));
        if (!mesh.uvs.empty()) add_textures(chart, surface, mesh, used, attributes, material, pbr);
        pbr["metallicFactor"] = 0;
        pbr["roughnessFactor"] = kRoughness;
        material["pbrMetallicRoughness"] = std::move(pbr);
        if (is_open(surface)) material["doubleSided"] = true;

        const std::size_t indices = buffer_.add_indices(renumbered(mesh.faces, used), used.size());
        root_["materials"].push_back(std::move(material));
        root_["meshes"].push_back(Json{{"name", name},
                                       {"primitives", Json::array({Json{{"attributes", std::move(attributes)},
                                                                        {"indices", indices},
                                                                        {"material", k},
                                                                        {"mode", kTriangles}}})}});
        Json node{{"name", name}, {"mesh", k}};
        if (chart.offset != std::array<double, 3>{0, 0, 0}) node["translation"] = chart.offset;
        root_["nodes"][0]["children"].push_back(root_["nodes"].size());
        root_["nodes"].push_back(std::move(node));
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
        root_["accessors"] = buffer_.accessors;
        root_["bufferViews"] = buffer_.views;
        root_["buffers"] = Json::array({Json{{"byteLength", buffer_.bytes().size()}}});
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
    /// The vertices that a face names, in their order.
    static std::vector<std::uint32_t> number_vertices(const ChartMesh& mesh) {
        std::vector<char> named(mesh.positions.size(), 0);
        for (const Face& face : mesh.faces)
            for (const std::uint32_t v : face) named[v] = 1;
        std::vector<std::uint32_t> used;
        for (std::uint32_t v = 0; v < named.size(); ++v)
            if (named[v] != 0) used.push_back(v);
        return used;
    }
    static std::vector<Face> renumbered(std::vector<Face> faces, const std::vector<std::uint32_t>& used) {
        std::vector<std::uint32_t> number(used.back() + std::size_t{1}, 0);
        for (std::uint32_t k = 0; k < used.size(); ++k) number[used[k]] = k;
        for (Face& face : faces)
            for (std::uint32_t& v : face) v = number[v];
        return faces;
    }

    std::size_t add_positions(const std::vector<std::uint32_t>& used, const ChartMesh& mesh) {
        const auto positions = gathered<std::array<float, 3>>(used, mesh.positions, floats);
        std::array<float, 3> low = positions[0], high = positions[0];
        for (const std::array<float, 3>& p : positions)
            for (std::size_t c = 0; c < 3; ++c) {
                if (!std::isfinite(p[c]))
                    throw model::Error(model::codes::kNotFinite, "a vertex is not finite in single precision",
                                       "geometry");
                low[c] = std::min(low[c], p[c]), high[c] = std::max(high[c], p[c]);
            }
        const std::size_t accessor = buffer_.add_vertices(positions);
        // As double: the shortest text of a float need not be the same number to a reader that computes in double.
        for (const auto& [bound, values] : {std::pair{"min", low}, std::pair{"max", high}})
            buffer_.accessors[accessor][bound] = std::array<double, 3>{values[0], values[1], values[2]};
        return accessor;
    }

    /// Picture y grows with u, picture x with v; corner samples lie on the middles of corner texels.
    std::size_t add_uvs(const std::vector<std::uint32_t>& used, const ChartMesh& mesh, std::uint32_t across,
                        std::uint32_t down) {
        return buffer_.add_vertices(gathered<std::array<float, 2>>(used, mesh.uvs, [&](const Vec2d& uv) {
            return std::array{static_cast<float>((uv.y * (across - 1.0) + 0.5) / across),
                              static_cast<float>((uv.x * (down - 1.0) + 0.5) / down)};
        }));
    }
    std::size_t add_texture(const formats::Image& picture, const std::string& name) {
        const std::size_t view = buffer_.add_view(formats::encode_png(picture), 0);
        root_["images"].push_back(Json{{"name", name}, {"mimeType", "image/png"}, {"bufferView", view}});
        root_["textures"].push_back(Json{{"sampler", 0}, {"source", root_["images"].size() - 1}});
        return root_["textures"].size() - 1;
    }
    void add_textures(const Chart& chart, const bake::Reconstruction& surface, const ChartMesh& mesh,
                      const std::vector<std::uint32_t>& used, Json& attributes, Json& material, Json& pbr) {
        const std::string name = material["name"];
        const formats::Image colour = render::texture_picture(chart);
        std::vector<Vec3d> tangents;
        std::optional<formats::Image> normal_map;
        if (chart.find("bump") != nullptr && !mesh.normals.empty()) {
            tangents = vertex_tangents(mesh);
            normal_map = tangent_normal_map(chart, surface, mesh, tangents);
        }
        std::uint32_t across = chart.cols, down = chart.rows;
        if (!colour.pixels.empty())
            across = colour.width, down = colour.height;
        else if (normal_map)
            across = normal_map->width, down = normal_map->height;
        attributes["TEXCOORD_0"] = add_uvs(used, mesh, across, down);
        if (!colour.pixels.empty()) pbr["baseColorTexture"] = {{"index", add_texture(colour, name + " colour")}};
        if (!normal_map) return;
        Json texture{{"index", add_texture(*normal_map, name + " normal map")}};
        if (normal_map->width != across || normal_map->height != down) {
            attributes["TEXCOORD_1"] = add_uvs(used, mesh, normal_map->width, normal_map->height);
            texture["texCoord"] = 1;
        }
        attributes["TANGENT"] = buffer_.add_vertices(gathered<std::array<float, 4>>(used, tangents, [](const Vec3d& t) {
            const auto [x, y, z] = floats(t);
            return std::array{x, y, z, 1.0f};
        }));
        material["normalTexture"] = std::move(texture);
    }

    Json root_;
    Buffer buffer_;
};
}  // namespace

std::vector<std::byte> encode_glb(const model::MapSet& maps, const std::vector<std::vector<Face>>& coarse,
                                  render::UpAxis up) {
    Document document(maps, up);
    for (std::size_t k = 0; k < maps.charts.size(); ++k)
        document.add_chart(maps.charts[k], coarse.empty() ? nullptr : &coarse[k]);
    return document.encode();
}

}  // namespace dgm::exporter
