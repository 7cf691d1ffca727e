// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/mesh_formats.h
// Which files are meshes, by the ending of their names: what a folder search takes, and what it says about the rest.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string_view>

namespace dgm::formats {

/// True if the file name's extension is one that a folder search takes, in any case. A test imports a file of each.
[[nodiscard]] bool has_mesh_extension(const std::filesystem::path& path);

/// The place of the extension in the order OBJ, 3DS, PLY, ...: of several meshes that differ in their extension alone,
/// the one with the lowest rank gets the plain name. Files without such an extension come after all others.
[[nodiscard]] std::size_t mesh_rank(const std::filesystem::path& path);

/// Why a folder search leaves a file out that holds a mesh, as a remark such as "no importer; export it as GLB".
/// Empty for files that has_mesh_extension() takes, and for those that are no meshes.
[[nodiscard]] std::string_view why_left_out(const std::filesystem::path& path);

/// For programs that read maps, before they do: says so if `path` is a mesh, or a folder.
/// @throws model::Error kNotDgm for a file that is named like a mesh; kFileMissing for a folder without maps,
///         kReadFailed for one that has some
void check_map_name(const std::filesystem::path& path);

}  // namespace dgm::formats
