// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/stage_source.cpp
// Import, repair, and the pictures of the materials.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "baking/stages.h"
#include "baking/up_to_date.h"
#include "dgm/hash.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"

namespace dgm::bake {
namespace {

using model::Error;
namespace codes = model::codes;

[[noreturn]] void malformed(const std::string& message) {
    throw Error(codes::kImportFailed, "the mesh in memory is malformed: " + message);
}

void check_indices(const model::TriMesh& mesh) {
    const auto per_corner = [&](std::size_t count, const char* what) {
        if (count != 0 && count != 3 * mesh.faces.size())
            malformed(std::to_string(count) + " " + what + " for " + std::to_string(mesh.faces.size()) +
                      " faces; there must be three a face, or none");
    };
    per_corner(mesh.corner_normals.size(), "normals");
    per_corner(mesh.corner_uvs.size(), "texture coordinates");
    per_corner(mesh.corner_colours.size(), "colours");
    for (const model::Face& face : mesh.faces)
        for (const std::uint32_t v : face)
            if (v >= mesh.positions.size()) malformed("a face names vertex " + std::to_string(v));
    if (!mesh.face_materials.empty() && mesh.face_materials.size() != mesh.faces.size())
        malformed("there must be one material a face, or none");
    for (const std::uint32_t m : mesh.face_materials)
        if (m >= mesh.materials.size()) malformed("a face names material " + std::to_string(m));
}

template <class T>
void add(formats::Hasher& hasher, const std::vector<T>& values) {
    const std::uint64_t count = values.size();
    hasher.add(std::as_bytes(std::span(&count, 1)));
    hasher.add(std::as_bytes(std::span(values)));
}

formats::Hash128 hash_of(const model::TriMesh& mesh) {
    formats::Hasher hasher;
    add(hasher, mesh.positions);
    add(hasher, mesh.faces);
    add(hasher, mesh.corner_normals);
    add(hasher, mesh.corner_uvs);
    add(hasher, mesh.corner_colours);
    add(hasher, mesh.face_materials);
    return hasher.result();
}

/// Squared lengths of the deformation layer are stored as float.
void check_scale(double diagonal) {
    constexpr double kSmallest = 1e-15, kLargest = 1e15;
    if (diagonal > kSmallest && diagonal < kLargest) return;
    throw Error(codes::kScaleOutOfRange,
                fmt::format("the diagonal of the bounding box is {:.3g}; supported: 1e-15 to 1e15", diagonal));
}

/// The findings of the import. Files outside the mesh's folder are not named, since a name would tell of the machine:
/// then the hash stays empty, and the mesh is baked each time.
void name_inputs(const std::filesystem::path& source, const formats::ImportedMesh& read, SourceFacts& facts) {
    for (const std::filesystem::path& file : read.dependencies) {
        const std::filesystem::path name =
            file.lexically_normal().lexically_relative(source.parent_path().lexically_normal());
        if (name.empty() || name.is_absolute() || *name.begin() == "..") {
            facts.inputs.clear();
            return;
        }
        facts.inputs.push_back(name.generic_string());
    }
    facts.missing_inputs = read.missing;
    facts.inputs_hash = hash_inputs(source, facts.inputs, facts.missing_inputs);
}

}  // namespace

Imported import_file(const std::filesystem::path& source) {
    Imported out;
    formats::check_mesh_file(source);
    // The hashes come first: a file that changes while it is read makes the output stale, not wrong.
    out.facts.source_hash = formats::hash_file(source);
    out.facts.inputs_hash = hash_inputs(source);
    formats::ImportedMesh read = formats::read_mesh(source);
    if (out.facts.inputs_hash.empty()) name_inputs(source, read, out.facts);
    out.facts.name = source.filename().string();
    out.facts.vertices = read.mesh.positions.size();
    out.facts.faces = read.mesh.faces.size();
    out.facts.warnings = std::move(read.warnings);
    out.facts.remarks = std::move(read.remarks);
    out.facts.repairs = std::move(read.dropped);
    out.mesh = std::move(read.mesh);
    return out;
}

Imported import_mesh(model::TriMesh mesh, std::string name) {
    check_indices(mesh);
    Imported out;
    out.facts.source_hash = hash_of(mesh);
    out.facts.name = std::move(name);
    out.facts.vertices = mesh.positions.size();
    out.facts.faces = mesh.faces.size();
    out.mesh = std::move(mesh);
    return out;
}

Repaired repair_source(Imported imported) {
    RepairedMesh repaired = repair(imported.mesh);
    check_scale(repaired.frame.diagonal);
    Repaired out;
    out.frame = repaired.frame;
    out.components = std::move(repaired.components);
    out.materials = std::move(imported.mesh.materials);
    out.facts = std::move(imported.facts);
    out.facts.repairs.insert(out.facts.repairs.end(), repaired.counts.begin(), repaired.counts.end());
    for (TriMesh& component : out.components) {
        complete_normals(component);
        out.areas.push_back(surface_area(component));
    }
    out.largest = static_cast<std::size_t>(std::max_element(out.areas.begin(), out.areas.end()) - out.areas.begin());
    return out;
}

MaterialImages load_images(std::span<const model::Material> materials, const std::filesystem::path& fabric,
                           std::vector<std::string>& warnings) {
    MaterialImages out;
    const auto try_read = [&](const std::filesystem::path& path, auto read, auto& into) {
        if (path.empty()) return;
        try {
            into = read(path);
        } catch (const Error& e) {
            warnings.push_back("texture " + path.filename().string() + " left out: " + e.what());
        }
    };
    for (const model::Material& material : materials) {
        try_read(material.diffuse_map, formats::read_image, out.colour.emplace_back());
        auto& height = out.height.emplace_back();
        if (material.bump_is_normal_map)
            warnings.push_back("normal map " + material.bump_map.filename().string() +
                               " left out: only height maps go into the bump layer");
        else
            try_read(material.bump_map, formats::read_height, height);
    }
    if (!fabric.empty()) out.fabric = formats::read_image(fabric);
    return out;
}

}  // namespace dgm::bake
