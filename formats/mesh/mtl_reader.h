// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/mtl_reader.h
// MTL material libraries, as far as a bake needs them.
#pragma once
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "mesh/material_files.h"
#include "model/tri_mesh.h"

namespace dgm::formats {

/// A material, and how its picture lies in texture space: map coordinate = uv * scale + offset (MTL's -s and -o).
struct MtlMaterial {
    model::Material material;
    model::Vec2d uv_scale{1, 1}, uv_offset{0, 0};
    [[nodiscard]] bool moves_uv() const {
        return !(uv_scale == model::Vec2d{1, 1}) || !(uv_offset == model::Vec2d{0, 0});
    }
};

using MtlLibrary = std::map<std::string, MtlMaterial, std::less<>>;

/// Reads `path` into `library`; a material that is there already is kept, as the first of two definitions counts.
/// Known: newmtl, Kd, d, Tr, map_Kd, map_Bump, bump, norm, map_Kn, with their options. Found textures go to
/// `dependencies`, missing or misunderstood ones to `warnings`.
/// @throws model::Error kReadFailed, kTooLarge, kIoTrouble
void read_mtl(const std::filesystem::path& path, FileFinder& finder, MtlLibrary& library,
              std::vector<std::string>& warnings, std::vector<std::filesystem::path>& dependencies);

/// Reads the files of the `mtllib` statements of an OBJ, each once: the rest of the line as one name with spaces, or
/// several names. Libraries that are found go to `dependencies`, those that are missing to `warnings`.
/// @throws model::Error kIoTrouble; a library that cannot be read for another reason is left out with a warning
void read_mtl_libraries(std::span<const std::string> statements, FileFinder& finder, MtlLibrary& library,
                        std::vector<std::string>& warnings, std::vector<std::filesystem::path>& dependencies);

/// True if a bump picture's name says that it is a normal map ("..._normal.png", "..._nrm.jpg").
[[nodiscard]] bool is_normal_map_name(const std::filesystem::path& file);

/// 0..1 to a byte, rounded; a word that is not a number counts as 1.
[[nodiscard]] std::uint8_t byte_of_unit(double value);

}  // namespace dgm::formats
