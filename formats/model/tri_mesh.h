// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/tri_mesh.h
// A triangle mesh with per-corner attributes, shared by every reader, the geometry and every writer.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "model/vec.h"

namespace dgm::model {

/// 8-bit RGBA, sRGB, straight alpha.
struct Rgba8 {
    std::uint8_t r = 255, g = 255, b = 255, a = 255;
    friend constexpr bool operator==(const Rgba8&, const Rgba8&) = default;
};

/// A picture file that a material names. It lies on disk, or inside the mesh's own file as in a GLB.
struct PictureFile {
    std::filesystem::path path = {};  ///< on disk, resolved; inside a mesh file its name there; empty: no picture
    std::shared_ptr<const std::string> bytes = {};  ///< the picture file itself, if the mesh's file holds it

    [[nodiscard]] bool empty() const { return path.empty(); }
    /// As messages name it: the file's name without its folder.
    [[nodiscard]] std::string name() const { return path.filename().string(); }
    friend bool operator==(const PictureFile& a, const PictureFile& b) {
        return a.path == b.path && (a.bytes == b.bytes || (a.bytes && b.bytes && *a.bytes == *b.bytes));
    }
};

struct Material {
    std::string name;
    Rgba8 diffuse;  ///< used where there is no texture
    PictureFile diffuse_map;
    PictureFile bump_map;  ///< height map or tangent-space normal map
    bool bump_is_normal_map = false;
    double bump_scale = 1;  ///< MTL's -bm
    friend bool operator==(const Material&, const Material&) = default;
};

/// Corner arrays are empty, or hold three entries a face: entry 3*f+k belongs to corner k of face f.
struct TriMesh {
    std::vector<Vec3d> positions;  ///< source units
    std::vector<Face> faces;
    std::vector<Vec3d> corner_normals;  ///< unit, or (0,0,0) where the source has none
    std::vector<Vec2d> corner_uvs;      ///< texture coordinates, v up (OBJ convention)
    std::vector<Rgba8> corner_colours;
    std::vector<std::uint32_t> face_materials;  ///< empty, or one index into `materials` a face
    std::vector<Material> materials;
    /// Of each vertex, its point of the surface; empty: each vertex is a point of its own. Vertices of one point lie on
    /// the two sides of a curve along which a surface without an inside was opened (geometry/repair/open_one_sided.h).
    std::vector<std::uint32_t> points;

    [[nodiscard]] std::array<Vec3d, 3> corners(std::size_t f) const {
        return {positions[faces[f][0]], positions[faces[f][1]], positions[faces[f][2]]};
    }
};

}  // namespace dgm::model
