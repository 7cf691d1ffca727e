// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/assimp_reader.h
// 3DS and all other kinds of mesh files, through assimp.
#pragma once
#include <filesystem>
#include <string>

#include "mesh/mesh_reader.h"

namespace dgm::formats {

/// See read_mesh. Not for OBJ.
/// @throws as read_mesh
[[nodiscard]] ImportedMesh read_with_assimp(const std::filesystem::path& path, const MeshReadLimits& limits);

/// True if assimp has an importer for this extension (".3ds").
[[nodiscard]] bool assimp_knows_extension(const std::string& extension);

}  // namespace dgm::formats
