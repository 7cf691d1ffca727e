// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/obj_writer.cpp
#include "mesh/mesh_writer.h"

#include <charconv>
#include <map>
#include <set>

#include "files/whole_file.h"
#include "mesh/mtl_reader.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using model::TriMesh;

void append(std::string& out, double value) {
    char digits[32];  // the longest shortest form of a double has 24 characters
    const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
    (void)error;
    out.append(digits, end);
}

void append(std::string& out, std::uint64_t value) {
    char digits[20];
    const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
    (void)error;
    out.append(digits, end);
}

template <class... Numbers>
void append_line(std::string& out, const char* keyword, Numbers... numbers) {
    out += keyword;
    ((out += ' ', append(out, numbers)), ...);
    out += '\n';
}

void check_sizes(const TriMesh& mesh, const fs::path& path) {
    const std::size_t corners = 3 * mesh.faces.size();
    const auto fits = [&](std::size_t size) { return size == 0 || size == corners; };
    bool good = fits(mesh.corner_normals.size()) && fits(mesh.corner_uvs.size()) && fits(mesh.corner_colours.size()) &&
                (mesh.face_materials.empty() || mesh.face_materials.size() == mesh.faces.size());
    for (const model::Face& face : mesh.faces)
        for (const std::uint32_t v : face) good = good && v < mesh.positions.size();
    for (const std::uint32_t material : mesh.face_materials) good = good && material < mesh.materials.size();
    if (!good) throw model::Error(codes::kInternal, "mesh arrays disagree", path.string());
}

/// Numbers distinct values in the order of their first corner, from 1.
template <class Value, class Key>
std::vector<std::uint32_t> number_values(const std::vector<Value>& values, Key key, std::vector<Value>& distinct) {
    std::map<decltype(key(values[0])), std::uint32_t> numbers;
    std::vector<std::uint32_t> out;
    out.reserve(values.size());
    for (const Value& value : values) {
        const auto [entry, is_new] = numbers.try_emplace(key(value), static_cast<std::uint32_t>(distinct.size() + 1));
        if (is_new) distinct.push_back(value);
        out.push_back(entry->second);
    }
    return out;
}

/// Names are words of a line in OBJ: blanks and line ends inside would end them.
std::string one_word(std::string name) {
    for (char& c : name)
        if (static_cast<unsigned char>(c) <= ' ') c = '_';
    return name;
}

/// A name for each material.
std::vector<std::string> material_names(const TriMesh& mesh) {
    std::vector<std::string> out;
    std::set<std::string> used;
    for (const model::Material& material : mesh.materials) {
        std::string name = one_word(material.name.empty() ? "material" : material.name);
        if (!used.insert(name).second) {
            name += "_" + std::to_string(out.size());
            while (!used.insert(name).second) name += "_";
        }
        out.push_back(name);
    }
    return out;
}

std::string mtl_text(const TriMesh& mesh, const std::vector<std::string>& names, const ObjWriteOptions& options) {
    std::string out;
    const auto material = [&](const std::string& name, const model::Material& m, const std::string& diffuse_map,
                              const std::string& bump_map) {
        out += "newmtl " + name + "\n";
        append_line(out, "Kd", m.diffuse.r / 255.0, m.diffuse.g / 255.0, m.diffuse.b / 255.0);
        append_line(out, "d", m.diffuse.a / 255.0);
        if (!diffuse_map.empty()) out += "map_Kd " + diffuse_map + "\n";
        if (bump_map.empty()) return;
        for (const bool as_normals : {false, true}) {
            if (as_normals ? !m.bump_is_normal_map : m.bump_is_normal_map && !is_normal_map_name(bump_map)) continue;
            out += as_normals ? "norm " : "map_Bump ";
            if (m.bump_scale != 1) {
                out += "-bm ";
                append(out, m.bump_scale);
                out += ' ';
            }
            out += bump_map + "\n";
        }
    };
    if (mesh.materials.empty()) material("surface", {}, options.texture, options.bump);
    for (std::size_t k = 0; k < mesh.materials.size(); ++k) {
        const model::Material& m = mesh.materials[k];
        material(names[k], m, m.diffuse_map.path.generic_string(), m.bump_map.path.generic_string());
    }
    return out;
}

/// Each corner's number of its texture coordinate and normal; empty where the mesh has none.
struct CornerNumbers {
    std::vector<std::uint32_t> uvs, normals;
};

CornerNumbers append_attributes(std::string& out, const TriMesh& mesh, const ObjWriteOptions& options) {
    CornerNumbers numbers;
    std::vector<model::Vec2d> uvs;
    if (options.uvs && !mesh.corner_uvs.empty())
        numbers.uvs = number_values(
            mesh.corner_uvs,
            [](const model::Vec2d& t) {
                return std::array{t.x, t.y};
            },
            uvs);
    for (const auto& t : uvs) append_line(out, "vt", t.x, t.y);

    std::vector<model::Vec3d> normals;
    if (options.normals && !mesh.corner_normals.empty())
        numbers.normals = number_values(
            mesh.corner_normals,
            [](const model::Vec3d& n) {
                return std::array{n.x, n.y, n.z};
            },
            normals);
    for (const auto& n : normals) append_line(out, "vn", n.x, n.y, n.z);
    return numbers;
}

void append_face(std::string& out, const model::Face& face, std::size_t f, const CornerNumbers& numbers) {
    out += 'f';
    for (std::size_t k = 0; k < 3; ++k) {
        out += ' ';
        append(out, std::uint64_t{face[k]} + 1);
        if (numbers.uvs.empty() && numbers.normals.empty()) continue;
        out += '/';
        if (!numbers.uvs.empty()) append(out, std::uint64_t{numbers.uvs[3 * f + k]});
        if (numbers.normals.empty()) continue;
        out += '/';
        append(out, std::uint64_t{numbers.normals[3 * f + k]});
    }
    out += '\n';
}

}  // namespace

void write_obj(const fs::path& path, const TriMesh& mesh, const ObjWriteOptions& options) {
    check_sizes(mesh, path);
    const bool with_mtl = options.write_mtl || !options.texture.empty() || !options.bump.empty();
    std::string out;
    if (with_mtl) out += "mtllib " + path.stem().string() + ".mtl\n";
    for (const auto& p : mesh.positions) append_line(out, "v", p.x, p.y, p.z);
    const CornerNumbers numbers = append_attributes(out, mesh, options);

    const std::vector<std::string> names = material_names(mesh);
    if (with_mtl && mesh.materials.empty()) out += "usemtl surface\n";
    std::uint32_t material = static_cast<std::uint32_t>(-1);
    auto object = options.objects.begin();
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        for (; object != options.objects.end() && object->first_face <= f; ++object)
            out += "o " + one_word(object->name) + "\n";
        if (with_mtl && !mesh.face_materials.empty() && mesh.face_materials[f] != material) {
            material = mesh.face_materials[f];
            out += "usemtl " + names[material] + "\n";
        }
        append_face(out, mesh.faces[f], f, numbers);
    }
    if (!options.comment.empty()) out += "# " + options.comment + "\n";
    if (with_mtl) write_whole_file(fs::path(path).replace_extension(".mtl"), mtl_text(mesh, names, options));
    write_whole_file(path, out);
}

}  // namespace dgm::formats
