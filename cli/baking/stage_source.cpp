// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/stage_source.cpp
// Import, repair, and the pictures of the materials.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "baking/stages.h"
#include "baking/up_to_date.h"
#include "dgm/hash.h"
#include "mesh/asset_folders.h"
#include "mesh/mesh_reader.h"
#include "model/codes.h"
#include "model/shortage.h"

namespace dgm::bake {
namespace {

using model::Error;
namespace codes = model::codes;

/// More charts a program takes only if it asks for them (dgm::OpenOptions::max_charts).
constexpr std::size_t kMostCharts = std::size_t{1} << 16;

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

/// The findings of the import.
void name_inputs(const std::filesystem::path& source, std::span<const std::filesystem::path> asset_roots,
                 const formats::ImportedMesh& read, SourceFacts& facts) {
    const formats::AssetFolders folders(source, asset_roots);
    for (const std::filesystem::path& file : read.dependencies) {
        std::string name = folders.name_of(file);
        if (name.empty()) {  // it was there a moment ago: unknown inputs, so that the mesh is baked again next time
            facts.inputs.clear();
            return;
        }
        facts.inputs.push_back(std::move(name));
    }
    facts.missing_inputs = read.missing;
    facts.inputs_hash = hash_inputs(source, facts.inputs, facts.missing_inputs, asset_roots);
}

/// A warning, since a surface without an inside is more often a fault of the model than a Klein bottle.
void warn_of_one_sided(Repaired& source) {
    const auto one_sided = static_cast<std::size_t>(
        std::count_if(source.components.begin(), source.components.end(),
                      [](const model::TriMesh& component) { return !component.points.empty(); }));
    if (one_sided == 0) return;
    const std::size_t all = source.components.size();
    const std::string subject =
        all == 1 ? std::string("the surface has")
                 : fmt::format("{} of {} components {}", one_sided, all, one_sided == 1 ? "has" : "have");
    source.facts.warnings.push_back(
        codes::kOneSided.id() + ": " + subject +
        " one side: cut open along a seam across which normals point to opposite sides; no volume is enclosed");
}

}  // namespace

Imported import_file(const std::filesystem::path& source, std::span<const std::filesystem::path> asset_roots) {
    Imported out;
    formats::check_mesh_file(source);
    // The hashes come first: a file that changes while it is read makes the output stale, not wrong.
    out.facts.source_hash = formats::hash_file(source);
    out.facts.inputs_hash = hash_inputs(source, asset_roots);
    formats::ImportedMesh read = formats::read_mesh(
        source, {.asset_roots = std::vector<std::filesystem::path>(asset_roots.begin(), asset_roots.end())});
    if (out.facts.inputs_hash.empty()) name_inputs(source, asset_roots, read, out.facts);
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
    if (repaired.components.size() > kMostCharts)
        throw Error(codes::kTooLarge, fmt::format("{} separate components; a map has at most {} charts, one for each",
                                                  repaired.components.size(), kMostCharts))
            .with_hint("join the components, or bake them in several files");
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
    warn_of_one_sided(out);
    out.largest = static_cast<std::size_t>(std::max_element(out.areas.begin(), out.areas.end()) - out.areas.begin());
    return out;
}

MaterialImages load_images(std::span<const model::Material> materials, const std::filesystem::path& fabric,
                           std::vector<std::string>& warnings) {
    MaterialImages out;
    const auto try_read = [&](const model::PictureFile& picture, auto read, auto& into) {
        if (picture.empty()) return;
        try {
            into = read(picture);
        } catch (const Error& e) {
            if (model::may_pass(e)) throw;
            warnings.push_back("texture " + picture.name() + " left out: " + e.what());
        }
    };
    for (const model::Material& material : materials) {
        try_read(material.diffuse_map, formats::read_image, out.colour.emplace_back());
        auto& height = out.height.emplace_back();
        if (material.bump_is_normal_map)
            warnings.push_back("normal map " + material.bump_map.name() +
                               " left out: only height maps go into the bump layer");
        else
            try_read(material.bump_map, formats::read_height, height);
    }
    if (!fabric.empty()) out.fabric = formats::read_image({fabric});
    return out;
}

}  // namespace dgm::bake
