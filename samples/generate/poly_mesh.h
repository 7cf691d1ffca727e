// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/poly_mesh.h
// Polygon meshes as the samples build them, and the two file formats they leave in.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "model/vec.h"

namespace dgm::samples {

/// A triangle (n = 3) or quad (n = 4), counter-clockwise from outside.
struct Polygon {
    std::array<std::uint32_t, 4> vertex{};
    std::array<std::uint32_t, 4> uv{};  ///< into PolyMesh::uvs
    int n = 4;
    std::uint32_t group = 1;  ///< smoothing group; normals are averaged within one group only
};

struct PolyMesh {
    std::vector<model::Vec3d> positions;  ///< centimetres
    std::vector<model::Vec2d> uvs;        ///< v up
    std::vector<Polygon> polygons;
};

/// A named mesh within a file; all parts share the file's material.
struct Part {
    std::string name;  ///< at most 10 characters, 3DS objects have no more
    PolyMesh mesh;
};

/// Material of a file. Image names are relative to the mesh file; an empty one is left out.
struct MaterialText {
    std::string name;
    std::string colour_map, bump_map;
    double bump_scale = 0;  ///< MTL's -bm: centimetres between black and white of the bump map
    double shininess = 30;  ///< MTL's Ns
};

/// Adds cell (i, j) of a cells x cells grid; `quad` starts at the cell's lowest corner. A quad in a corner of the grid
/// has three vertices on the grid's border; it is split through the corner. Split the other way by another
/// triangulation, it would give a sliver where the border is rounded, and two grids sewn together would share that
/// diagonal.
void add_cell(PolyMesh& mesh, const Polygon& quad, int i, int j, int cells);

/// Rounds positions and UVs to 1e-5 so that a last-bit difference between two maths libraries does not reach the files.
void quantise(PolyMesh& mesh);

/// Reverses every polygon of a closed mesh whose signed volume is negative.
void orient_outward(PolyMesh& mesh);

/// Unit normal for each corner, 4 entries a polygon: area-weighted over the polygons of the same smoothing group.
std::vector<model::Vec3d> corner_normals(const PolyMesh& mesh);

/// Writes `path` and the .mtl beside it. Expects quantised parts. Throws model::Error (kWriteFailed).
void write_obj(const std::vector<Part>& parts, const MaterialText& material, const std::filesystem::path& path);

/// Writes an Autodesk 3D Studio file; vertices are split where UVs differ, quads become two triangles.
/// Throws model::Error (kWriteFailed), and kTooLarge above 65535 vertices or faces a part.
void write_3ds(const std::vector<Part>& parts, const MaterialText& material, const std::filesystem::path& path);

}  // namespace dgm::samples
