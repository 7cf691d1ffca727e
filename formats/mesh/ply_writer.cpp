// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/ply_writer.cpp
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <system_error>

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

/// The values of a vertex of the file beside its position.
using Attributes = std::array<std::uint32_t, 4>;  // three floats' bits, colour

Attributes attributes_of(const TriMesh& mesh, std::size_t corner, bool normals, bool colours) {
    Attributes out{};
    if (normals)
        for (int k = 0; k < 3; ++k)
            out[static_cast<std::size_t>(k)] =
                std::bit_cast<std::uint32_t>(static_cast<float>(mesh.corner_normals[corner][k]));
    if (colours) {
        const model::Rgba8 c = mesh.corner_colours[corner];
        out[3] = std::uint32_t{c.r} | std::uint32_t{c.g} << 8 | std::uint32_t{c.b} << 16 | std::uint32_t{c.a} << 24;
    }
    return out;
}

bool arrays_agree(const TriMesh& mesh, bool normals, bool colours) {
    const std::size_t corners = 3 * mesh.faces.size();
    bool good =
        (!normals || mesh.corner_normals.size() == corners) && (!colours || mesh.corner_colours.size() == corners);
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
PlyVertices split_by_attributes(const TriMesh& mesh, bool normals, bool colours) {
    constexpr std::uint32_t kUnset = std::numeric_limits<std::uint32_t>::max();
    PlyVertices out;
    out.source.resize(mesh.positions.size());
    for (std::uint32_t k = 0; k < out.source.size(); ++k) out.source[k] = k;
    out.attributes.resize(mesh.positions.size());
    out.faces = mesh.faces;
    if (!normals && !colours) return out;
    std::vector<std::uint32_t> first_corner(mesh.positions.size(), kUnset);
    std::map<std::pair<std::uint32_t, Attributes>, std::uint32_t> further;
    for (std::size_t corner = 0; corner < 3 * out.faces.size(); ++corner) {
        std::uint32_t& vertex = out.faces[corner / 3][corner % 3];
        const Attributes own = attributes_of(mesh, corner, normals, colours);
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

std::string ply_header(const PlyVertices& vertices, bool doubles, bool normals, bool colours) {
    const std::string real = doubles ? "double" : "float";
    std::string out =
        "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(vertices.source.size()) + "\n";
    for (const char* axis : {"x", "y", "z"}) out += "property " + real + " " + axis + "\n";
    if (normals)
        for (const char* axis : {"nx", "ny", "nz"}) out += std::string("property float ") + axis + "\n";
    if (colours)
        for (const char* channel : {"red", "green", "blue", "alpha"})
            out += std::string("property uchar ") + channel + "\n";
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

void write_file(const fs::path& path, const std::string& bytes) {
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    if (!file) throw model::Error(codes::kWriteFailed, "the file cannot be created", path.string());
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (file) return;
    std::error_code error;
    fs::remove(path, error);
    throw model::Error(codes::kWriteFailed, "the file cannot be written", path.string());
}

}  // namespace

void write_ply(const fs::path& path, const TriMesh& mesh, const PlyWriteOptions& options) {
    const bool normals = options.normals && !mesh.corner_normals.empty();
    const bool colours = options.colours && !mesh.corner_colours.empty();
    if (!arrays_agree(mesh, normals, colours))
        throw model::Error(codes::kInternal, "mesh arrays disagree", path.string());
    const PlyVertices vertices = split_by_attributes(mesh, normals, colours);
    std::string out = ply_header(vertices, options.doubles, normals, colours);
    for (std::size_t k = 0; k < vertices.source.size(); ++k) {
        append_position(out, mesh.positions[vertices.source[k]], options.doubles);
        if (normals)
            for (std::size_t axis = 0; axis < 3; ++axis) append_bytes(out, vertices.attributes[k][axis]);
        if (colours) append_bytes(out, vertices.attributes[k][3]);
    }
    for (const model::Face& face : vertices.faces) {
        append_bytes(out, std::uint8_t{3});
        for (const std::uint32_t v : face) append_bytes(out, v);
    }
    write_file(path, out);
}

}  // namespace dgm::formats
