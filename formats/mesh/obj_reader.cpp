// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/obj_reader.cpp
// Faces may stand before their vertices, so indices are resolved when read (negative ones count from there) and checked
// at the end.
#include "mesh/obj_reader.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "mesh/material_files.h"
#include "mesh/mtl_reader.h"
#include "mesh/obj_text.h"
#include "mesh/polygon.h"
#include "mesh/text_input.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using model::TriMesh;
using model::Vec2d;
using model::Vec3d;

constexpr std::size_t kMaxWarnings = 100;

/// Gives `out` the materials that the file names, in the order of first use.
/// @return  beside each material, how its picture lies in texture space
std::vector<MtlMaterial> resolve_materials(const ObjText& text, const fs::path& path, const MeshReadLimits& limits,
                                           ImportedMesh& out) {
    FileFinder finder(path, limits.asset_roots);
    MtlLibrary library;
    read_mtl_libraries(text.libraries, finder, library, out.warnings, out.dependencies);
    std::vector<MtlMaterial> materials;
    for (const std::string& name : text.material_names) {
        const auto found = library.find(name);
        if (found != library.end()) {
            out.mesh.materials.push_back(found->second.material);
            materials.push_back(found->second);
            continue;
        }
        // Where no library was read, every material lacks its definition; a missing library has its own warning.
        if (!library.empty()) out.warnings.push_back("material not defined: " + name);
        out.mesh.materials.emplace_back().name = name;
        materials.push_back({});
    }
    return materials;
}

/// False if a position is missing; a missing texture coordinate or normal is taken out of its corner.
bool check_corners(ObjText& text, const ObjPolygon& polygon) {
    for (std::uint32_t k = 0; k < polygon.size; ++k) {
        ObjCorner& corner = text.corners[polygon.first + k];
        if (corner.position >= text.positions.size()) {
            text.tallies.bad_positions.add(polygon.spot);
            return false;
        }
        if (corner.uv != kObjAbsent && corner.uv >= text.uvs.size()) {
            corner.uv = kObjAbsent;
            text.tallies.bad_uvs.add(polygon.spot);
        }
        if (corner.normal != kObjAbsent && corner.normal >= text.normals.size()) {
            corner.normal = kObjAbsent;
            text.tallies.bad_normals.add(polygon.spot);
        }
    }
    return true;
}

/// The polygon's corners without immediate repetitions, which would spoil its triangulation; triangles stay as they
/// are, for repair to judge.
void collect_ring(ObjText& text, const ObjPolygon& polygon, std::vector<ObjCorner>& ring) {
    ring.clear();
    for (std::uint32_t k = 0; k < polygon.size; ++k) {
        const ObjCorner& corner = text.corners[polygon.first + k];
        if (polygon.size > 3 && !ring.empty() && ring.back().position == corner.position) {
            text.tallies.repeated.add(polygon.spot);
        } else {
            ring.push_back(corner);
        }
    }
    while (polygon.size > 3 && ring.size() > 1 && ring.back().position == ring.front().position) {
        ring.pop_back();
        text.tallies.repeated.add(polygon.spot);
    }
    while (!ring.empty() && ring.size() < 3) ring.push_back(ring.back());
}

/// Splits the polygons into the faces of `mesh`, with their materials. Faces without one share a default material
/// behind the named ones. @return  the corners of the faces, three each
/// @throws model::Error kPolygonCrosses
std::vector<ObjCorner> build_faces(ObjText& text, const fs::path& path, TriMesh& mesh) {
    const bool use_materials = !text.material_names.empty();
    const auto default_material = static_cast<std::uint32_t>(text.material_names.size());
    bool needs_default = false;
    std::vector<CornerTriple> triples;
    std::vector<Vec3d> loop;
    std::vector<ObjCorner> ring, face_corners;
    PolygonBudget budget;
    mesh.faces.reserve(text.triangles);
    for (const ObjPolygon& polygon : text.polygons) {
        if (!check_corners(text, polygon)) continue;
        collect_ring(text, polygon, ring);
        loop.clear();
        for (const ObjCorner& corner : ring) loop.push_back(text.positions[corner.position]);
        triples.clear();
        if (!triangulate_polygon(loop, triples, budget)) text.tallies.fans.add(polygon.spot);
        if (budget.is_crossed()) throw crossed_polygons(obj_place(path, polygon.spot));
        for (const CornerTriple& triple : triples) {
            mesh.faces.push_back({ring[triple[0]].position, ring[triple[1]].position, ring[triple[2]].position});
            for (const std::uint32_t k : triple) face_corners.push_back(ring[k]);
            if (!use_materials) continue;
            needs_default = needs_default || polygon.material == kObjAbsent;
            mesh.face_materials.push_back(polygon.material == kObjAbsent ? default_material : polygon.material);
        }
    }
    if (needs_default) mesh.materials.push_back({});
    return face_corners;
}

[[noreturn]] void no_faces(const ObjText& text, const fs::path& path) {
    std::string message = "no usable faces";
    ObjSpot spot;
    const auto mention = [&](const ObjTally& tally, const char* what) {
        if (tally.count == 0) return;
        message += "; " + std::to_string(tally.count) + " " + what;
        if (spot.line == 0) spot = tally.first;
    };
    mention(text.tallies.bad_positions, "faces name vertices that do not exist");
    mention(text.tallies.malformed, "face statements cannot be read");
    mention(text.tallies.too_few, "faces have fewer than three corners");
    mention(text.tallies.lines, "line elements");
    mention(text.tallies.points, "point elements");
    mention(text.tallies.free_forms, "free-form elements");
    if (text.positions.empty()) message += "; no vertices";
    throw model::Error(codes::kNoFaces, message, spot.line == 0 ? path.string() : obj_place(path, spot));
}

void fill_uvs(const ObjText& text, const std::vector<ObjCorner>& face_corners,
              const std::vector<MtlMaterial>& materials, TriMesh& mesh) {
    if (std::all_of(face_corners.begin(), face_corners.end(), [](const ObjCorner& c) { return c.uv == kObjAbsent; }))
        return;
    mesh.corner_uvs.reserve(face_corners.size());
    for (std::size_t k = 0; k < face_corners.size(); ++k) {
        Vec2d uv = face_corners[k].uv == kObjAbsent ? Vec2d{} : text.uvs[face_corners[k].uv];
        const std::uint32_t material = mesh.face_materials.empty() ? kObjAbsent : mesh.face_materials[k / 3];
        if (material < materials.size() && materials[material].moves_uv()) {
            const MtlMaterial& m = materials[material];
            uv = {uv.x * m.uv_scale.x + m.uv_offset.x, uv.y * m.uv_scale.y + m.uv_offset.y};
        }
        mesh.corner_uvs.push_back(uv);
    }
}

void fill_normals(const ObjText& text, const std::vector<ObjCorner>& face_corners, TriMesh& mesh) {
    if (std::all_of(face_corners.begin(), face_corners.end(),
                    [](const ObjCorner& c) { return c.normal == kObjAbsent; }))
        return;
    for (const ObjCorner& c : face_corners)
        mesh.corner_normals.push_back(c.normal == kObjAbsent ? Vec3d{} : text.normals[c.normal]);
}

/// Colours count from 0 to 1, or to 255 if any is above 1.
void fill_colours(ObjText& text, const std::vector<ObjCorner>& face_corners, TriMesh& mesh) {
    if (text.colours.empty()) return;
    text.colours.resize(text.positions.size(), ObjColour{-1, -1, -1, -1});
    double largest = 0;
    for (const ObjColour& c : text.colours)
        for (const double channel : {c.r, c.g, c.b, c.a})
            if (std::isfinite(channel)) largest = std::max(largest, channel);
    const double unit = largest > 1 ? 255 : 1;
    const auto byte = [&](double value) { return value == -1 ? std::uint8_t{255} : byte_of_unit(value / unit); };
    mesh.corner_colours.reserve(face_corners.size());
    for (const ObjCorner& corner : face_corners) {
        const ObjColour& c = text.colours[corner.position];
        mesh.corner_colours.push_back({byte(c.r), byte(c.g), byte(c.b), byte(c.a)});
    }
}

/// Each warning once, in the order of its first mention, and no more than kMaxWarnings.
std::vector<std::string> unique_warnings(const std::vector<std::string>& warnings) {
    std::set<std::string_view> seen;
    std::vector<std::string> unique;
    for (const std::string& warning : warnings)
        if (seen.insert(warning).second && seen.size() <= kMaxWarnings) unique.push_back(warning);
    if (seen.size() > kMaxWarnings) unique.push_back(std::to_string(seen.size() - kMaxWarnings) + " more warnings");
    return unique;
}

void report_tallies(const ObjTallies& tallies, ImportedMesh& out) {
    const auto drop = [&](const ObjTally& tally, const char* what) {
        if (tally.count > 0) out.dropped.emplace_back(what, tally.count);
    };
    drop(tallies.bad_positions, "faces with vertices that do not exist");
    drop(tallies.malformed, "face statements that cannot be read");
    drop(tallies.too_few, "faces with fewer than three corners");
    drop(tallies.repeated, "repeated corners of polygons");
    drop(tallies.bad_uvs, "texture coordinates that do not exist");
    drop(tallies.bad_normals, "normals that do not exist");
    drop(tallies.lines, "line elements");
    drop(tallies.points, "point elements");
    drop(tallies.free_forms, "free-form elements");
    const auto warn = [&](const ObjTally& tally, const std::string& what) {
        if (tally.count > 0)
            out.warnings.push_back(std::to_string(tally.count) + " " + what + ", first in line " +
                                   std::to_string(tally.first.line) + ", column " + std::to_string(tally.first.column));
    };
    warn(tallies.bad_numbers, "numbers are missing or cannot be read and count as NaN");
    warn(tallies.bad_positions, "faces name vertices that do not exist");
    warn(tallies.fans, "polygons are flat or cross themselves and were split as fans");
}

}  // namespace

ImportedMesh read_obj(const fs::path& path, const MeshReadLimits& limits) {
    const std::string bytes = read_text_file(path, limits.max_file_bytes);
    if (trim(bytes).empty())
        throw model::Error(codes::kNoFaces, "the file is empty", path.string())
            .with_hint("copy or export it again: nothing is in it");
    ObjText text = parse_obj(bytes, path, limits);
    ImportedMesh out;
    const std::vector<MtlMaterial> materials = resolve_materials(text, path, limits, out);
    const std::vector<ObjCorner> face_corners = build_faces(text, path, out.mesh);
    if (out.mesh.faces.empty()) no_faces(text, path);
    fill_uvs(text, face_corners, materials, out.mesh);
    fill_normals(text, face_corners, out.mesh);
    fill_colours(text, face_corners, out.mesh);
    out.mesh.positions = std::move(text.positions);
    report_tallies(text.tallies, out);
    out.warnings = unique_warnings(out.warnings);
    auto& files = out.dependencies;
    std::sort(files.begin(), files.end());
    files.erase(std::unique(files.begin(), files.end()), files.end());
    return out;
}

bool looks_like_obj(std::string_view text) {
    LineReader lines(text);
    std::string_view line;
    for (int statements = 0; statements < 8 && lines.next(line);) {
        const std::string_view word = next_word(line);
        if (word.empty() || word.front() == '#') continue;
        bool known = false;
        for (const char* k : {"v", "vt", "vn", "f", "o", "g", "s", "mtllib", "usemtl"}) known = known || word == k;
        if (!known) return false;
        ++statements;
        if (statements == 1 && lines.number() > 200) return false;
        if (word == "v" || word == "f") return true;
    }
    return false;
}

}  // namespace dgm::formats
