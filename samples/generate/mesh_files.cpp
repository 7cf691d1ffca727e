// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/mesh_files.cpp
// OBJ with MTL, and 3DS. Numbers go through std::to_chars, which knows no locale.
//
// 3DS is a tree of chunks: u16 id, u32 length with the six bytes of the head, then data and inner chunks,
// little-endian. Ids as in the 3D Studio File Toolkit (Autodesk, 1996).
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <tuple>

#include "model/codes.h"
#include "poly_mesh.h"

namespace dgm::samples {
namespace {
using model::Vec2d;
using model::Vec3d;
namespace codes = model::codes;

void write_file(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw model::Error(codes::kWriteFailed, "cannot write the file", path.string());
}

template <class Number>
std::string text(Number value) {
    std::array<char, 32> buffer{};
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
    return {buffer.data(), end.ptr};
}

template <class... Pieces>
void put(std::string& out, const Pieces&... pieces) {
    (out.append(pieces), ...);
}

std::string mtl_text(const MaterialText& m) {
    std::string out;
    put(out, "newmtl ", m.name, "\nKa 0 0 0\nKd 1 1 1\nKs 0.2 0.2 0.2\nNs ", text(m.shininess), "\nillum 2\n");
    if (!m.colour_map.empty()) put(out, "map_Kd ", m.colour_map, "\n");
    if (!m.bump_map.empty()) put(out, "map_Bump -bm ", text(m.bump_scale), " ", m.bump_map, "\n");
    return out;
}

// One part; `base` counts the v, vt, vn lines of the parts before it.
void append_obj(std::string& out, const Part& part, std::array<std::size_t, 3>& base) {
    put(out, "o ", part.name, "\n");
    for (const Vec3d& p : part.mesh.positions) put(out, "v ", text(p.x), " ", text(p.y), " ", text(p.z), "\n");
    for (const Vec2d& t : part.mesh.uvs) put(out, "vt ", text(t.x), " ", text(t.y), "\n");

    std::map<std::array<long, 3>, std::size_t> known;  // normals in 1e-4 steps, in order of first use
    std::string normal_lines, face_lines;
    const std::vector<Vec3d> normals = corner_normals(part.mesh);
    std::uint32_t group = 0;
    for (std::size_t f = 0; f < part.mesh.polygons.size(); ++f) {
        const Polygon& p = part.mesh.polygons[f];
        if (p.group != group) put(face_lines, "s ", text(group = p.group), "\n");
        face_lines += "f";
        for (std::size_t k = 0; k < static_cast<std::size_t>(p.n); ++k) {
            const Vec3d n = normals[4 * f + k] * 1e4;
            const std::array<long, 3> key{std::lround(n.x), std::lround(n.y), std::lround(n.z)};
            const auto [entry, fresh] = known.try_emplace(key, known.size());
            if (fresh) {
                normal_lines += "vn";
                for (const long c : key) put(normal_lines, " ", text(static_cast<double>(c) / 1e4));
                normal_lines += "\n";
            }
            put(face_lines, " ", text(base[0] + p.vertex[k] + 1), "/", text(base[1] + p.uv[k] + 1), "/",
                text(base[2] + entry->second + 1));
        }
        face_lines += "\n";
    }
    out += normal_lines + face_lines;
    base = {base[0] + part.mesh.positions.size(), base[1] + part.mesh.uvs.size(), base[2] + known.size()};
}

/// Grows a 3DS file; a chunk is opened, filled and closed, which fills in its length.
class ChunkWriter {
 public:
    void open(std::uint16_t id) {
        starts_.push_back(bytes_.size());
        u16(id);
        u32(0);
    }
    void close() {
        const std::size_t start = starts_.back();
        starts_.pop_back();
        const auto size = static_cast<std::uint32_t>(bytes_.size() - start);
        for (std::size_t k = 0; k < 4; ++k) bytes_[start + 2 + k] = static_cast<char>((size >> (8 * k)) & 0xffU);
    }
    void u8(unsigned v) { bytes_.push_back(static_cast<char>(v & 0xffU)); }
    void u16(unsigned v) {
        u8(v);
        u8(v >> 8U);
    }
    void u32(std::uint32_t v) {
        u16(v & 0xffffU);
        u16(v >> 16U);
    }
    void f32(double v) { u32(std::bit_cast<std::uint32_t>(static_cast<float>(v))); }
    void string(std::string_view s) {
        bytes_.append(s);
        u8(0);
    }
    void colour(std::uint16_t id, unsigned level) {
        open(id);
        open(0x0011);
        u8(level);
        u8(level);
        u8(level);
        close();
        close();
    }
    void percent(unsigned value) {
        open(0x0030);
        u16(value);
        close();
    }
    [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
    std::string bytes_;
    std::vector<std::size_t> starts_;
};

void append_material(ChunkWriter& w, const MaterialText& m) {
    w.open(0xAFFF);
    w.open(0xA000);
    w.string(m.name);
    w.close();
    w.colour(0xA010, 0);    // ambient
    w.colour(0xA020, 255);  // diffuse
    w.colour(0xA030, 51);   // specular
    const auto map = [&w](std::uint16_t id, const std::string& file) {
        if (file.empty()) return;
        w.open(id);
        w.percent(100);
        w.open(0xA300);
        w.string(file);
        w.close();
        w.close();
    };
    map(0xA200, m.colour_map);
    map(0xA230, m.bump_map);
    w.close();
}

struct SplitMesh {
    std::vector<Vec3d> positions;
    std::vector<Vec2d> uvs;                           // one a vertex
    std::vector<std::array<std::uint32_t, 4>> faces;  // three corners and the smoothing group
};

SplitMesh split_for_3ds(const PolyMesh& mesh) {
    SplitMesh out;
    std::map<std::tuple<std::uint32_t, double, double>, std::uint32_t> known;
    for (const Polygon& p : mesh.polygons) {
        std::array<std::uint32_t, 4> corner{};
        for (std::size_t k = 0; k < static_cast<std::size_t>(p.n); ++k) {
            const Vec2d uv = mesh.uvs[p.uv[k]];
            const auto [entry, fresh] =
                known.try_emplace({p.vertex[k], uv.x, uv.y}, static_cast<std::uint32_t>(out.positions.size()));
            if (fresh) {
                out.positions.push_back(mesh.positions[p.vertex[k]]);
                out.uvs.push_back(uv);
            }
            corner[k] = entry->second;
        }
        for (std::size_t k = 2; k < static_cast<std::size_t>(p.n); ++k)
            out.faces.push_back({corner[0], corner[k - 1], corner[k], p.group});
    }
    return out;
}

void append_object(ChunkWriter& w, const Part& part, const std::string& material) {
    const SplitMesh m = split_for_3ds(part.mesh);
    if (m.positions.size() > 65535 || m.faces.size() > 65535)
        throw model::Error(codes::kTooLarge, "3DS holds 65535 vertices and faces an object", part.name);
    w.open(0x4000);
    w.string(part.name);
    w.open(0x4100);
    w.open(0x4110);
    w.u16(static_cast<unsigned>(m.positions.size()));
    for (const Vec3d& p : m.positions) {
        w.f32(p.x);
        w.f32(p.y);
        w.f32(p.z);
    }
    w.close();
    w.open(0x4140);
    w.u16(static_cast<unsigned>(m.uvs.size()));
    for (const Vec2d& t : m.uvs) {
        w.f32(t.x);
        w.f32(t.y);
    }
    w.close();
    w.open(0x4160);  // local frame: the identity
    for (const double v : {1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0.}) w.f32(v);
    w.close();
    w.open(0x4120);
    w.u16(static_cast<unsigned>(m.faces.size()));
    for (const auto& f : m.faces) {
        w.u16(f[0]);
        w.u16(f[1]);
        w.u16(f[2]);
        w.u16(7);  // all three edges visible
    }
    w.open(0x4130);
    w.string(material);
    w.u16(static_cast<unsigned>(m.faces.size()));
    for (unsigned f = 0; f < m.faces.size(); ++f) w.u16(f);
    w.close();
    w.open(0x4150);
    for (const auto& f : m.faces) w.u32(1U << (f[3] - 1U));
    w.close();
    w.close();
    w.close();
    w.close();
}
}  // namespace

void write_obj(const std::vector<Part>& parts, const MaterialText& material, const std::filesystem::path& path) {
    const std::filesystem::path mtl = std::filesystem::path(path).replace_extension(".mtl");
    write_file(mtl, mtl_text(material));
    std::string out;
    put(out, "mtllib ", mtl.filename().string(), "\nusemtl ", material.name, "\n");
    std::array<std::size_t, 3> base{};
    for (const Part& part : parts) append_obj(out, part, base);
    write_file(path, out);
}

void write_3ds(const std::vector<Part>& parts, const MaterialText& material, const std::filesystem::path& path) {
    ChunkWriter w;
    w.open(0x4D4D);
    w.open(0x0002);
    w.u32(3);
    w.close();
    w.open(0x3D3D);
    w.open(0x3D3E);
    w.u32(3);
    w.close();
    append_material(w, material);
    w.open(0x0100);
    w.f32(1);  // one unit a unit
    w.close();
    for (const Part& part : parts) append_object(w, part, material.name);
    w.close();
    w.close();
    write_file(path, w.bytes());
}

}  // namespace dgm::samples
