// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/ply_writer.cpp
#include <array>
#include <bit>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <map>

#include "files/whole_file.h"
#include "mesh/mesh_writer.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

static_assert(std::endian::native == std::endian::little, "files are little-endian and written as they stand");

namespace codes = model::codes;
namespace fs = std::filesystem;
using model::TriMesh;

template <class Value>
void append_bytes(std::string& out, Value value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    out.append(bytes, sizeof value);
}

/// Which attributes a file has.
struct Fields {
    bool normals = false, uvs = false, colours = false;
    [[nodiscard]] bool any() const { return normals || uvs || colours; }
};

/// The values of a vertex of the file beside its position.
using Attributes = std::array<std::uint32_t, 6>;  // bits of the normal's floats and of s and t, colour
constexpr std::size_t kUv = 3, kColour = 5;

std::uint32_t float_bits(double value) {
    return std::bit_cast<std::uint32_t>(static_cast<float>(value));
}

Attributes attributes_of(const TriMesh& mesh, std::size_t corner, const Fields& fields) {
    Attributes out{};
    if (fields.normals)
        for (int k = 0; k < 3; ++k) out[static_cast<std::size_t>(k)] = float_bits(mesh.corner_normals[corner][k]);
    if (fields.uvs) {
        out[kUv] = float_bits(mesh.corner_uvs[corner].x);
        out[kUv + 1] = float_bits(mesh.corner_uvs[corner].y);
    }
    if (fields.colours) {
        const model::Rgba8 c = mesh.corner_colours[corner];
        out[kColour] =
            std::uint32_t{c.r} | std::uint32_t{c.g} << 8 | std::uint32_t{c.b} << 16 | std::uint32_t{c.a} << 24;
    }
    return out;
}

bool arrays_agree(const TriMesh& mesh, const Fields& fields) {
    const std::size_t corners = 3 * mesh.faces.size();
    bool good = (!fields.normals || mesh.corner_normals.size() == corners) &&
                (!fields.uvs || mesh.corner_uvs.size() == corners) &&
                (!fields.colours || mesh.corner_colours.size() == corners);
    for (const model::Face& face : mesh.faces)
        for (const std::uint32_t v : face) good = good && v < mesh.positions.size();
    return good;
}

/// The vertices of a file, which has attributes at vertices only, and the faces that join them.
struct PlyVertices {
    std::vector<std::uint32_t> source;   ///< vertex of the mesh, of each vertex
    std::vector<Attributes> attributes;  ///< of each vertex
    std::vector<model::Face> faces;
};

/// Vertex k of the mesh is vertex k of the file with the attributes of its first corner; others follow.
PlyVertices split_by_attributes(const TriMesh& mesh, const Fields& fields) {
    constexpr std::uint32_t kUnset = std::numeric_limits<std::uint32_t>::max();
    PlyVertices out;
    out.source.resize(mesh.positions.size());
    for (std::uint32_t k = 0; k < out.source.size(); ++k) out.source[k] = k;
    out.attributes.resize(mesh.positions.size());
    out.faces = mesh.faces;
    if (!fields.any()) return out;
    std::vector<std::uint32_t> first_corner(mesh.positions.size(), kUnset);
    std::map<std::pair<std::uint32_t, Attributes>, std::uint32_t> further;
    for (std::size_t corner = 0; corner < 3 * out.faces.size(); ++corner) {
        std::uint32_t& vertex = out.faces[corner / 3][corner % 3];
        const Attributes own = attributes_of(mesh, corner, fields);
        if (first_corner[vertex] == kUnset) {
            first_corner[vertex] = static_cast<std::uint32_t>(corner);
            out.attributes[vertex] = own;
        } else if (out.attributes[vertex] != own) {
            const auto [entry, is_new] =
                further.try_emplace({vertex, own}, static_cast<std::uint32_t>(out.source.size()));
            if (is_new) {
                out.source.push_back(vertex);
                out.attributes.push_back(own);
            }
            vertex = entry->second;
        }
    }
    return out;
}

std::string ply_header(const PlyVertices& vertices, const Fields& fields, const PlyWriteOptions& options,
                       std::size_t bytes_behind) {
    std::string out = "ply\nformat binary_little_endian 1.0\n";
    if (!options.comment.empty()) out += "comment " + options.comment + " " + std::to_string(bytes_behind) + "\n";
    if (!options.texture.empty()) out += "comment TextureFile " + options.texture + "\n";
    out += "element vertex " + std::to_string(vertices.source.size()) + "\n";
    const auto properties = [&](const char* type, std::initializer_list<const char*> names) {
        for (const char* name : names) out += std::string("property ") + type + " " + name + "\n";
    };
    properties(options.doubles ? "double" : "float", {"x", "y", "z"});
    if (fields.normals) properties("float", {"nx", "ny", "nz"});
    if (fields.uvs) properties("float", {"s", "t"});
    if (fields.colours) properties("uchar", {"red", "green", "blue", "alpha"});
    return out + "element face " + std::to_string(vertices.faces.size()) +
           "\nproperty list uchar uint vertex_indices\nend_header\n";
}

void append_position(std::string& out, const model::Vec3d& p, bool doubles) {
    for (int axis = 0; axis < 3; ++axis) {
        if (doubles) {
            append_bytes(out, p[axis]);
        } else {
            append_bytes(out, static_cast<float>(p[axis]));
        }
    }
}

}  // namespace

void write_ply(const fs::path& path, const TriMesh& mesh, const PlyWriteOptions& options) {
    const Fields fields{options.normals && !mesh.corner_normals.empty(), options.uvs && !mesh.corner_uvs.empty(),
                        options.colours && !mesh.corner_colours.empty()};
    if (!arrays_agree(mesh, fields)) throw model::Error(codes::kInternal, "mesh arrays disagree", path.string());
    const PlyVertices vertices = split_by_attributes(mesh, fields);
    std::string body;
    for (std::size_t k = 0; k < vertices.source.size(); ++k) {
        append_position(body, mesh.positions[vertices.source[k]], options.doubles);
        const Attributes& own = vertices.attributes[k];
        if (fields.normals)
            for (std::size_t axis = 0; axis < 3; ++axis) append_bytes(body, own[axis]);
        if (fields.uvs) append_bytes(body, own[kUv]), append_bytes(body, own[kUv + 1]);
        if (fields.colours) append_bytes(body, own[kColour]);
    }
    for (const model::Face& face : vertices.faces) {
        append_bytes(body, std::uint8_t{3});
        for (const std::uint32_t v : face) append_bytes(body, v);
    }
    write_whole_file(path, ply_header(vertices, fields, options, body.size()) + body);
}

}  // namespace dgm::formats
