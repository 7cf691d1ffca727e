// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/up_to_date.h
// Finds out whether an output is up to date. Every output names its origin: the program's version, a hash of the mesh,
// one of the settings, and one of the files that the mesh names (BakeReport::inputs_hash). Contents count, not paths or
// times, so nothing is kept beside the outputs and a folder may be moved or copied.
#pragma once
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "baking/bake_options.h"
#include "baking/bake_report.h"

namespace dgm::bake {

/// Name and version of the program, as outputs store it; another version bakes again.
[[nodiscard]] const char* generator();

/// XXH3-128 in hexadecimal over the names (without folders) and contents of the files that the mesh names, and over the
/// names of missing files: a texture that appears later changes it. Empty where only an import could find out.
/// @throws model::Error kReadFailed and the like, for the mesh or a file it names
[[nodiscard]] std::string hash_inputs(const std::filesystem::path& mesh_file,
                                      std::span<const std::filesystem::path> asset_roots = {});

/// The same where an import has told: of the files `inputs`, from the mesh's folder or an asset root
/// (AssetFolders::name_of), and of names that lead nowhere. Empty if one of `missing` is there now.
/// @throws model::Error kFileMissing, also for a name that leads elsewhere; kReadFailed
[[nodiscard]] std::string hash_inputs(const std::filesystem::path& mesh_file, const std::vector<std::string>& inputs,
                                      const std::vector<std::string>& missing,
                                      std::span<const std::filesystem::path> asset_roots = {});

/// Every file that a bake of `mesh_file` reads: the mesh, what it names, and the texture of `options`. `report` is that
/// of the bake; it tells where only an import does.
[[nodiscard]] std::vector<std::filesystem::path> input_files(const std::filesystem::path& mesh_file,
                                                             const BakeOptions& options, const BakeReport& report);

/// The stored report, without times, if each of `outputs` (.dgm, .exr, at least one of them; .glb, .obj, .ply) is whole
/// and was made by this version from these contents with these settings. A mesh carries the stamp of the map that it
/// was made of (export/map_stamp.h), and its textures must be there; of a .dgm and an EXR, the one that was edited.
/// nullopt otherwise, and for whatever cannot be read. For formats where only an import tells what they name, the
/// report has what the import of that bake found.
///
/// A .dgm is read and checked wholly, of an EXR the headers and whether all rows are there. Not thread-safe: HDF5.
[[nodiscard]] std::optional<BakeReport> up_to_date(const std::filesystem::path& mesh_file,
                                                   const std::vector<std::filesystem::path>& outputs,
                                                   const BakeOptions& options);

/// The layers that dgm-edit has put into a .dgm or .exr, each once, in their order of time: "stiffness", "texture".
/// None for a map as it was baked and for what cannot be read. Not thread-safe: HDF5.
/// @throws model::Error if the system failed for the moment (model::may_pass)
[[nodiscard]] std::vector<std::string> edited_layers(const std::filesystem::path& map);
[[nodiscard]] std::vector<std::string> edited_layers(const BakeReport& report);

/// The name of the mesh that a .dgm or .exr was baked from; nullopt if its content does not say that dgm-bake made it,
/// if somebody has edited it since (nobody else has that work), or it cannot be read. Not thread-safe: HDF5.
[[nodiscard]] std::optional<std::string> baked_from(const std::filesystem::path& map);

}  // namespace dgm::bake
