// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/source_inputs.h
// Which further files a mesh file names, without importing it: what a look whether a bake is up to date needs.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dgm::formats {

struct SourceInputs {
    std::vector<std::filesystem::path> files;  ///< material libraries and textures that were found; sorted, no doubles
    std::vector<std::string> missing;          ///< what was named and not found, in plain language, in file order
};

/// OBJ: its material libraries and the textures they name; 3DS: the textures of its materials; PLY, STL and OFF name
/// nothing. Textures of materials that no face uses count, too. nullopt for every other format: only a full import
/// tells there. Never fails on what a file holds: what cannot be understood names nothing.
/// @throws model::Error kFileMissing, kReadFailed, kTooLarge
[[nodiscard]] std::optional<SourceInputs> source_inputs(const std::filesystem::path& mesh_file);

}  // namespace dgm::formats
