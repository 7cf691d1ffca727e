// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/mesh_reader.h
// Import of a mesh file of any kind into one TriMesh.
//
// 3DS and everything that is not OBJ goes through assimp. OBJ + MTL has a reader of ours: assimp as packaged keeps
// coordinates as float, which loses a unit sphere at 1e7 and every mesh at 1e-200, and it renumbers vertices, so double
// positions could not be put back reliably.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "mesh/mesh_formats.h"
#include "model/tri_mesh.h"

namespace dgm::formats {

struct MeshReadLimits {
    std::uint64_t max_file_bytes = std::uint64_t{4} << 30;
    std::uint64_t max_faces = 20'000'000;  ///< triangles, after polygons are split
    std::uint64_t max_vertices = 60'000'000;
    std::vector<std::filesystem::path> asset_roots = {};  ///< folders beside the mesh's that hold files it may name
};

struct ImportedMesh {
    model::TriMesh mesh;
    std::vector<std::string> warnings;                ///< plain language, one fact each, in file order
    std::vector<std::string> remarks;                 ///< what was done as the file asks: "1 unit is 1 cm: ..."
    std::vector<std::filesystem::path> dependencies;  ///< MTL files and textures that were found; sorted, no doubles
    std::vector<std::string> missing;                 ///< files that were looked for in vain; not for OBJ
    std::vector<std::pair<std::string, std::uint64_t>> dropped;  ///< what was left out, by kind; no zero counts
};

/// Looks at a mesh's kind and size, and at no byte: read_mesh() would refuse it, too.
/// @throws model::Error kFileMissing, kReadFailed (also for a folder, a pipe or a device), kNoFaces if empty, kTooLarge
void check_mesh_file(const std::filesystem::path& path, const MeshReadLimits& limits = {});

/// Reads OBJ (with MTL), 3DS and whatever else assimp reads, chosen by extension, or by content where the extension
/// says nothing. All objects are merged, node transforms applied, polygons triangulated; faces keep the file's order.
/// Vertices that no face uses stay, and so do those that are not finite: repair counts and drops them.
/// corner_normals, corner_uvs and corner_colours are empty only if no face has them. Paths in materials are resolved
/// against the mesh's folder and the asset roots without regard to case (material_files.h); one that is missing or lies
/// elsewhere is a warning and an empty path.
/// FBX, Collada and glTF come out in metres and with y up, as far as the file states its units and axes; 3DS with y up.
/// Deterministic. May abort or take long on hostile files of the kinds that assimp reads: run it in a worker process.
/// @throws model::Error kFileMissing, kReadFailed, kNoFaces, kImportFailed (place FILE or FILE:LINE:COLUMN), kTooLarge;
///         kPolygonCrosses for polygons of many corners that cross themselves (polygon.h); kReferenceOutside,
///         kReferenceNoFile for a file without which there is no mesh (the buffer of a glTF)
[[nodiscard]] ImportedMesh read_mesh(const std::filesystem::path& path, const MeshReadLimits& limits = {});

}  // namespace dgm::formats
