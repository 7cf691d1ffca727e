// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/source_inputs.h
// Finds the further files that a mesh file names, without importing it: a check whether a bake is up to date needs
// them.
#pragma once
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dgm::formats {

struct SourceInputs {
    std::vector<std::filesystem::path> files;  ///< material libraries and textures that were found; sorted, no doubles
    std::vector<std::string> missing;          ///< missing files, in plain language, in file order
};

/// OBJ: its material libraries and the textures they name; 3DS: the textures of its materials; PLY, STL and OFF name
/// nothing. Textures of materials that no face uses count, too. nullopt for every other format: only a full import can
/// find out. Files are looked for as FileFinder does. Never fails on the content of a file: words that cannot be
/// understood name nothing.
/// @throws model::Error kFileMissing, kReadFailed, kTooLarge
[[nodiscard]] std::optional<SourceInputs> source_inputs(const std::filesystem::path& mesh_file,
                                                        std::span<const std::filesystem::path> asset_roots = {});

}  // namespace dgm::formats
