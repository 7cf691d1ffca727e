// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/tri_mesh.h
// A triangle mesh with per-corner attributes, shared by every reader, the geometry and every writer.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "model/vec.h"

namespace dgm::model {

/// 8-bit RGBA, sRGB, straight alpha.
struct Rgba8 {
    std::uint8_t r = 255, g = 255, b = 255, a = 255;
    friend constexpr bool operator==(const Rgba8&, const Rgba8&) = default;
};

struct Material {
    std::string name;
    Rgba8 diffuse;                      ///< used where there is no texture
    std::filesystem::path diffuse_map;  ///< absolute or relative to the working folder, resolved; empty if none
    std::filesystem::path bump_map;     ///< height map or tangent-space normal map
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
