// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/obj_text.h
// Parses the statements of an OBJ file, before its faces are checked.
#pragma once
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/mesh_reader.h"
#include "model/vec.h"

namespace dgm::formats {

inline constexpr std::uint32_t kObjAbsent = std::numeric_limits<std::uint32_t>::max();
inline constexpr std::uint32_t kObjInvalid = kObjAbsent - 1;

/// Indices of one face corner, from 0; those of things that the file lacks are kObjInvalid or beyond the arrays.
struct ObjCorner {
    std::uint32_t position = kObjInvalid, uv = kObjAbsent, normal = kObjAbsent;
};

/// Line and column of the file, from 1; columns count bytes.
struct ObjSpot {
    std::uint64_t line = 0, column = 0;
};

struct ObjPolygon {
    std::uint32_t first = 0, size = 0;  ///< range of corners
    std::uint32_t material = kObjAbsent;
    ObjSpot spot;
};

/// -1: the file does not give this channel.
struct ObjColour {
    double r = 1, g = 1, b = 1, a = 1;
};

/// How often something happened, and where first.
struct ObjTally {
    std::uint64_t count = 0;
    ObjSpot first;
    void add(const ObjSpot& spot) {
        if (count++ == 0) first = spot;
    }
};

/// Faults and statements without use, by kind. The parser fills the first two rows, building the faces the others.
struct ObjTallies {
    ObjTally bad_numbers, malformed, too_few;
    ObjTally lines, points, free_forms;
    ObjTally bad_positions, bad_uvs, bad_normals;
    ObjTally repeated, fans;
};

/// The statements of a file, in its order.
struct ObjText {
    std::vector<model::Vec3d> positions, normals;
    std::vector<model::Vec2d> uvs;
    std::vector<ObjColour> colours;  ///< empty, or as far as the last coloured vertex
    std::vector<ObjCorner> corners;
    std::vector<ObjPolygon> polygons;
    std::uint64_t triangles = 0;                         ///< once the polygons are split
    std::vector<std::string> material_names, libraries;  ///< in the order of first use
    ObjTallies tallies;
};

/// FILE:LINE:COLUMN
[[nodiscard]] std::string obj_place(const std::filesystem::path& path, const ObjSpot& spot);

/// @throws model::Error kTooLarge beyond the limits, with the place in `path`
[[nodiscard]] ObjText parse_obj(std::string_view text, const std::filesystem::path& path, const MeshReadLimits& limits);

}  // namespace dgm::formats
