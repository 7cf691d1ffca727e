// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/obj_reader.h
// Wavefront OBJ in double precision.
#pragma once
#include <filesystem>

#include "mesh/mesh_reader.h"

namespace dgm::formats {

/// Reads polygons, texture coordinates, normals, vertex colours and materials; see read_mesh. Lines, points and
/// free-form elements are counted as dropped.
/// Vertex colours (`v x y z r g b [a]`) are 0..1, or 0..255 if any of them is above 1. `v x y z w` is divided by w.
/// @throws as read_mesh
[[nodiscard]] ImportedMesh read_obj(const std::filesystem::path& path, const MeshReadLimits& limits);

/// True if the first lines of a text are OBJ statements.
[[nodiscard]] bool looks_like_obj(std::string_view text);

}  // namespace dgm::formats
