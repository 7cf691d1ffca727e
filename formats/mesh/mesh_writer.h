// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/mesh_writer.h
// Export of a TriMesh as OBJ (+ MTL) or PLY.
#pragma once
#include <filesystem>
#include <string>

#include "model/tri_mesh.h"

namespace dgm::formats {

struct ObjWriteOptions {
    bool normals = true;       ///< corner_normals, where the mesh has them
    bool uvs = true;           ///< corner_uvs, where the mesh has them
    bool write_mtl = false;    ///< also PATH with the extension .mtl; always if a texture is named
    std::string texture = {};  ///< file name for map_Kd of a mesh without materials; empty for none
    std::string bump = {};     ///< file name for map_Bump of a mesh without materials; empty for none
};

/// Writes `v`, `vt`, `vn`, `usemtl`, `f` in this order. Numbers are the shortest that read back to the same double,
/// whatever the locale; equal attributes share one line. With write_mtl, materials[].diffuse_map and bump_map are
/// written as they stand, with forward slashes.
/// Deterministic. @throws model::Error kWriteFailed; kInternal if indices or array sizes disagree
void write_obj(const std::filesystem::path& path, const model::TriMesh& mesh, const ObjWriteOptions& options = {});

struct PlyWriteOptions {
    bool normals = true;   ///< a vertex that corners see with several normals is written once for each
    bool colours = true;   ///< likewise
    bool doubles = false;  ///< positions as double instead of float
};

/// Binary little-endian PLY: x y z [nx ny nz] [red green blue alpha], faces as uchar count and uint indices. Vertices
/// keep their order; one that corners see with different normals or colours is repeated after the last vertex.
/// Deterministic. @throws as write_obj
void write_ply(const std::filesystem::path& path, const model::TriMesh& mesh, const PlyWriteOptions& options = {});

}  // namespace dgm::formats
