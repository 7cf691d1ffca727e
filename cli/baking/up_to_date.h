// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/up_to_date.h
// Is what a bake would write there already? Every output carries what it was made from: the program's version, a hash
// of the mesh, one of the settings, and one of the files that the mesh names (BakeReport::inputs_hash). Contents count,
// not paths or times, so nothing is kept beside the outputs and a folder may be moved or copied.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "baking/bake_options.h"
#include "baking/bake_report.h"

namespace dgm::bake {

/// What outputs call their maker; another version bakes again.
[[nodiscard]] const char* generator();

/// XXH3-128 in hexadecimal over the names (without folders) and contents of the files that the mesh names, and over
/// what it names in vain: a texture that turns up later changes it. Empty where only an import would tell.
/// @throws model::Error kReadFailed and the like, for the mesh or a file it names
[[nodiscard]] std::string hash_inputs(const std::filesystem::path& mesh_file);

/// Every file that a bake of `mesh_file` reads: the mesh, what it names, and the texture of `options`. Where only an
/// import would tell, the mesh and the texture.
[[nodiscard]] std::vector<std::filesystem::path> input_files(const std::filesystem::path& mesh_file,
                                                             const BakeOptions& options);

/// The stored report, without times, if each of `outputs` (.dgm, .exr, at least one of them; .glb, .obj, .ply) is whole
/// and was made by this version from these contents with these settings. A mesh carries the stamp of the map that it
/// was made of (export/map_stamp.h), and its textures must be there. nullopt otherwise, and for whatever cannot be
/// read; always for formats where only an import tells what they name.
///
/// A .dgm is read and checked wholly, of an EXR the headers and whether all rows are there. Not thread-safe: HDF5.
[[nodiscard]] std::optional<BakeReport> up_to_date(const std::filesystem::path& mesh_file,
                                                   const std::vector<std::filesystem::path>& outputs,
                                                   const BakeOptions& options);

}  // namespace dgm::bake
