// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/mesh_writer.h
// Export of a TriMesh as OBJ (+ MTL) or PLY.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "model/tri_mesh.h"

namespace dgm::formats {

/// A part of an OBJ with a name of its own: the faces from `first_face` to the next object's.
struct ObjObject {
    std::string name;
    std::size_t first_face = 0;
};

struct ObjWriteOptions {
    bool normals = true;                  ///< corner_normals, where the mesh has them
    bool uvs = true;                      ///< corner_uvs, where the mesh has them
    bool write_mtl = false;               ///< also PATH with the extension .mtl; always if a texture is named
    std::string texture = {};             ///< file name for map_Kd of a mesh without materials; empty for none
    std::string bump = {};                ///< file name for map_Bump of a mesh without materials; empty for none
    std::vector<ObjObject> objects = {};  ///< `o` lines, by growing first_face; empty: none
    std::string comment = {};  ///< one line, the last of the file, so that it also says that the file is whole
};

/// Writes `v`, `vt`, `vn`, then `o`, `usemtl`, `f`. Numbers are the shortest that read back to the same double,
/// whatever the locale; equal attributes share one line. With write_mtl, materials[].diffuse_map and bump_map are
/// written as they stand, with forward slashes. Blanks in names of objects and materials become underscores.
///
/// A normal map is written as `norm`, which three.js and assimp read, and as `map_Bump`, in which Blender expects one,
/// if its name says what it is (is_normal_map_name): readers that look for heights there go by the name.
/// Deterministic. @throws model::Error kWriteFailed; kInternal if indices or array sizes disagree
void write_obj(const std::filesystem::path& path, const model::TriMesh& mesh, const ObjWriteOptions& options = {});

struct PlyWriteOptions {
    bool normals = true;       ///< a vertex that corners see with several normals is written once for each
    bool colours = true;       ///< likewise
    bool uvs = true;           ///< likewise
    bool doubles = false;      ///< positions as double instead of float
    std::string texture = {};  ///< file name for `comment TextureFile`, which MeshLab reads; empty for none
    std::string comment = {};  ///< one line; the number of bytes behind the header is added; empty for none
};

/// Binary little-endian PLY: x y z [nx ny nz] [s t] [red green blue alpha], faces as uchar count and uint indices.
/// Vertices keep their order; one that corners see with different attributes is repeated after the last vertex.
/// Deterministic. @throws as write_obj
void write_ply(const std::filesystem::path& path, const model::TriMesh& mesh, const PlyWriteOptions& options = {});

}  // namespace dgm::formats
