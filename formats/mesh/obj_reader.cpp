// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/obj_reader.cpp
// [OBJ] Alias|Wavefront. Object files (.obj), version 3.0. Advanced Visualizer manual, appendix B1.
//
// Faces may stand before their vertices, so indices are resolved when read (negative ones count from there) and checked
// at the end.
#include "mesh/obj_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>

#include "mesh/material_files.h"
#include "mesh/mtl_reader.h"
#include "mesh/polygon.h"
#include "mesh/text_input.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using model::Vec2d;
using model::Vec3d;

constexpr std::uint32_t kAbsent = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kInvalid = kAbsent - 1;
constexpr std::size_t kMaxWarnings = 100;

struct Corner {
    std::uint32_t position = kInvalid, uv = kAbsent, normal = kAbsent;
};

/// Line and column of the file, from 1; columns count bytes.
struct Spot {
    std::uint64_t line = 0, column = 0;
};

struct Polygon {
    std::uint32_t first = 0, size = 0;  ///< range of corners
    std::uint32_t material = kAbsent;
    Spot spot;
};

struct Colour {
    double r = 1, g = 1, b = 1, a = 1;
};

/// How often something happened, and where first.
struct Tally {
    std::uint64_t count = 0;
    Spot first;
    void add(const Spot& spot) {
        if (count++ == 0) first = spot;
    }
};

class ObjReader {
 public:
    ObjReader(const fs::path& path, const MeshReadLimits& limits) : path_(path), limits_(limits), finder_(path) {}

    ImportedMesh read() {
        const std::string text = read_text_file(path_, limits_.max_file_bytes);
        if (trim(text).empty()) throw model::Error(codes::kNoFaces, "the file is empty", path_.string());
        LineReader lines(text);
        std::string_view line;
        while (lines.next(line)) {
            line_start_ = line.data();
            spot_.line = lines.number();
            statement(line);
        }
        resolve_materials();
        build_faces();
        tell();
        return std::move(out_);
    }

 private:
    /// Of a word in the line that is being read.
    [[nodiscard]] Spot spot_of(std::string_view word) const {
        return {spot_.line, static_cast<std::uint64_t>(word.data() - line_start_) + 1};
    }

    void statement(std::string_view line) {
        const std::string_view word = next_word(line);
        if (word.empty() || word.front() == '#') return;
        spot_ = spot_of(word);
        if (word == "v") {
            read_position(line);
        } else if (word == "vt") {
            double uv[2] = {0, 0};
            read_numbers(line, uv);
            uvs_.push_back({uv[0], uv[1]});
        } else if (word == "vn") {
            double n[3] = {0, 0, 0};
            read_numbers(line, n);
            normals_.push_back(unit_or_zero({n[0], n[1], n[2]}));
        } else if (word == "f" || word == "fo") {
            read_face(line);
        } else if (word == "usemtl") {
            const auto [entry, is_new] =
                material_ids_.try_emplace(std::string(trim(line)), static_cast<std::uint32_t>(material_names_.size()));
            if (is_new) material_names_.push_back(entry->first);
            material_ = entry->second;
        } else if (word == "mtllib") {
            libraries_.emplace_back(trim(line));
        } else if (word == "l") {
            lines_.add(spot_);
        } else if (word == "p") {
            points_.add(spot_);
        } else if (word == "curv" || word == "curv2" || word == "surf") {
            free_forms_.add(spot_);
        }
    }

    /// Fills `values` from the words of the line as far as they go; a word that is no number becomes NaN.
    std::size_t read_numbers(std::string_view line, std::span<double> values) {
        std::size_t count = 0;
        while (count < values.size()) {
            const std::string_view word = next_word(line);
            if (word.empty() || word.front() == '#') break;
            const auto number = parse_number(word);
            if (!number) bad_numbers_.add(spot_of(word));
            values[count++] = number.value_or(std::numeric_limits<double>::quiet_NaN());
        }
        return count;
    }

    void read_position(std::string_view line) {
        constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
        double x[7] = {kNan, kNan, kNan, 1, 1, 1, 1};
        const std::size_t count = read_numbers(line, x);
        if (count < 3) bad_numbers_.add(spot_);
        Vec3d position{x[0], x[1], x[2]};
        if (count == 4 && x[3] != 1 && x[3] != 0 && std::isfinite(x[3])) position = position / x[3];
        if (positions_.size() >= limits_.max_vertices) too_large("vertices", limits_.max_vertices);
        positions_.push_back(position);
        if (count < 6) return;
        colours_.resize(positions_.size());
        colours_.back() = {x[3], x[4], x[5], count == 7 ? x[6] : -1};
    }

    static Vec3d unit_or_zero(const Vec3d& n) {
        const double largest = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
        if (!is_finite(n) || !(largest > 0)) return {0, 0, 0};
        return normalized(n / largest, {0, 0, 0});
    }

    /// One index of a corner: 1 is the first, -1 the last so far.
    static std::uint32_t resolve(std::int64_t index, std::size_t so_far) {
        if (index > 0) return index <= std::int64_t{kInvalid} ? static_cast<std::uint32_t>(index - 1) : kInvalid;
        const std::int64_t from_end = static_cast<std::int64_t>(so_far) + index;
        return index < 0 && from_end >= 0 ? static_cast<std::uint32_t>(from_end) : kInvalid;
    }

    /// "7", "7/8", "7//9", "7/8/9"; nothing if the word is none of them.
    std::optional<Corner> parse_corner(std::string_view word) const {
        std::int64_t index[3] = {0, 0, 0};
        bool present[3] = {false, false, false};
        for (int k = 0; k < 3; ++k) {
            const char* end = word.data() + word.size();
            const char* begin = word.data();
            if (!word.empty() && word.front() == '+') ++begin;
            const auto [stop, error] = std::from_chars(begin, end, index[k]);
            if (error == std::errc::result_out_of_range) index[k] = 0;
            present[k] = error != std::errc::invalid_argument;
            word.remove_prefix(static_cast<std::size_t>((present[k] ? stop : begin) - word.data()));
            // Some programs write "1.000/2.000".
            if (word.starts_with('.') && present[k])
                word.remove_prefix(std::min(word.find_first_not_of('0', 1), word.size()));
            if (word.empty()) break;
            if (word.front() != '/' || k == 2) return std::nullopt;
            word.remove_prefix(1);
        }
        if (!present[0]) return std::nullopt;
        Corner corner;
        corner.position = resolve(index[0], positions_.size());
        if (present[1]) corner.uv = resolve(index[1], uvs_.size());
        if (present[2]) corner.normal = resolve(index[2], normals_.size());
        return corner;
    }

    void read_face(std::string_view line) {
        const std::size_t first = corners_.size();
        for (std::string_view word = next_word(line); !word.empty() && word.front() != '#'; word = next_word(line)) {
            const auto corner = parse_corner(word);
            if (!corner) {
                malformed_.add(spot_of(word));
                corners_.resize(first);
                return;
            }
            corners_.push_back(*corner);
        }
        const std::size_t size = corners_.size() - first;
        if (size < 3) {
            too_few_.add(spot_);
            corners_.resize(first);
            return;
        }
        triangles_ += size - 2;
        if (triangles_ > limits_.max_faces) too_large("faces", limits_.max_faces);
        polygons_.push_back({static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(size), material_, spot_});
    }

    [[noreturn]] void too_large(const std::string& what, std::uint64_t limit) const {
        throw model::Error(codes::kTooLarge, "more than " + std::to_string(limit) + " " + what, place(spot_));
    }
    [[nodiscard]] std::string place(const Spot& spot) const {
        return path_.string() + ":" + std::to_string(spot.line) + ":" + std::to_string(spot.column);
    }

    // Materials -----------------------------------------------------------------------------------------------------

    void resolve_materials() {
        read_mtl_libraries(libraries_, finder_, library_, out_.warnings, out_.dependencies);
        for (const std::string& name : material_names_) {
            const auto found = library_.find(name);
            if (found == library_.end()) {
                // Without a library that is no news: a missing one was told above.
                if (!library_.empty()) out_.warnings.push_back("material not defined: " + name);
                out_.mesh.materials.emplace_back().name = name;
                mtl_.push_back({});
            } else {
                out_.mesh.materials.push_back(found->second.material);
                mtl_.push_back(found->second);
            }
        }
    }

    // Faces ---------------------------------------------------------------------------------------------------------

    void build_faces() {
        auto& mesh = out_.mesh;
        const bool use_materials = !material_names_.empty();
        const auto default_material = static_cast<std::uint32_t>(material_names_.size());
        bool needs_default = false, any_uv = false, any_normal = false;
        std::vector<CornerTriple> triples;
        std::vector<Vec3d> loop;
        std::vector<Corner> ring;
        mesh.faces.reserve(triangles_);
        std::vector<Corner> face_corners;
        for (const Polygon& polygon : polygons_) {
            if (!check_corners(polygon)) continue;
            collect_ring(polygon, ring);
            loop.clear();
            for (const Corner& corner : ring) loop.push_back(positions_[corner.position]);
            triples.clear();
            if (!triangulate_polygon(loop, triples)) fans_.add(polygon.spot);
            for (const CornerTriple& triple : triples) {
                mesh.faces.push_back({ring[triple[0]].position, ring[triple[1]].position, ring[triple[2]].position});
                for (const std::uint32_t k : triple) {
                    face_corners.push_back(ring[k]);
                    any_uv = any_uv || ring[k].uv != kAbsent;
                    any_normal = any_normal || ring[k].normal != kAbsent;
                }
                if (!use_materials) continue;
                needs_default = needs_default || polygon.material == kAbsent;
                mesh.face_materials.push_back(polygon.material == kAbsent ? default_material : polygon.material);
            }
        }
        if (needs_default) mesh.materials.push_back({});
        if (mesh.faces.empty()) no_faces();
        if (any_uv) fill_uvs(face_corners);
        if (any_normal)
            for (const Corner& c : face_corners)
                mesh.corner_normals.push_back(c.normal == kAbsent ? Vec3d{} : normals_[c.normal]);
        if (!colours_.empty()) fill_colours(face_corners);
        mesh.positions = std::move(positions_);
    }

    /// False if a position is missing; a missing texture coordinate or normal is taken out of its corner.
    bool check_corners(const Polygon& polygon) {
        for (std::uint32_t k = 0; k < polygon.size; ++k) {
            Corner& corner = corners_[polygon.first + k];
            if (corner.position >= positions_.size()) {
                bad_positions_.add(polygon.spot);
                return false;
            }
            if (corner.uv != kAbsent && corner.uv >= uvs_.size()) {
                corner.uv = kAbsent;
                bad_uvs_.add(polygon.spot);
            }
            if (corner.normal != kAbsent && corner.normal >= normals_.size()) {
                corner.normal = kAbsent;
                bad_normals_.add(polygon.spot);
            }
        }
        return true;
    }

    /// The polygon's corners without immediate repetitions, which would spoil its triangulation; triangles stay as they
    /// are, for repair to judge.
    void collect_ring(const Polygon& polygon, std::vector<Corner>& ring) {
        ring.clear();
        for (std::uint32_t k = 0; k < polygon.size; ++k) {
            const Corner& corner = corners_[polygon.first + k];
            if (polygon.size > 3 && !ring.empty() && ring.back().position == corner.position) {
                repeated_.add(polygon.spot);
            } else {
                ring.push_back(corner);
            }
        }
        while (polygon.size > 3 && ring.size() > 1 && ring.back().position == ring.front().position) {
            ring.pop_back();
            repeated_.add(polygon.spot);
        }
        while (!ring.empty() && ring.size() < 3) ring.push_back(ring.back());
    }

    [[noreturn]] void no_faces() const {
        std::string message = "no usable faces";
        Spot spot;
        const auto mention = [&](const Tally& tally, const char* what) {
            if (tally.count == 0) return;
            message += "; " + std::to_string(tally.count) + " " + what;
            if (spot.line == 0) spot = tally.first;
        };
        mention(bad_positions_, "faces name vertices that do not exist");
        mention(malformed_, "face statements cannot be read");
        mention(too_few_, "faces have fewer than three corners");
        mention(lines_, "line elements");
        mention(points_, "point elements");
        mention(free_forms_, "free-form elements");
        if (positions_.empty()) message += "; no vertices";
        throw model::Error(codes::kNoFaces, message, spot.line == 0 ? path_.string() : place(spot));
    }

    void fill_uvs(const std::vector<Corner>& face_corners) {
        auto& mesh = out_.mesh;
        mesh.corner_uvs.reserve(face_corners.size());
        for (std::size_t k = 0; k < face_corners.size(); ++k) {
            Vec2d uv = face_corners[k].uv == kAbsent ? Vec2d{} : uvs_[face_corners[k].uv];
            const std::uint32_t material = mesh.face_materials.empty() ? kAbsent : mesh.face_materials[k / 3];
            if (material < mtl_.size() && mtl_[material].moves_uv()) {
                const MtlMaterial& m = mtl_[material];
                uv = {uv.x * m.uv_scale.x + m.uv_offset.x, uv.y * m.uv_scale.y + m.uv_offset.y};
            }
            mesh.corner_uvs.push_back(uv);
        }
    }

    void fill_colours(const std::vector<Corner>& face_corners) {
        colours_.resize(positions_.size(), Colour{-1, -1, -1, -1});
        double largest = 0;
        for (const Colour& c : colours_)
            for (const double channel : {c.r, c.g, c.b, c.a})
                if (std::isfinite(channel)) largest = std::max(largest, channel);
        const double unit = largest > 1 ? 255 : 1;
        const auto byte = [&](double value) { return value == -1 ? std::uint8_t{255} : byte_of_unit(value / unit); };
        out_.mesh.corner_colours.reserve(face_corners.size());
        for (const Corner& corner : face_corners) {
            const Colour& c = colours_[corner.position];
            out_.mesh.corner_colours.push_back({byte(c.r), byte(c.g), byte(c.b), byte(c.a)});
        }
    }

    void tell() {
        const auto drop = [&](const Tally& tally, const char* what) {
            if (tally.count > 0) out_.dropped.emplace_back(what, tally.count);
        };
        drop(bad_positions_, "faces with vertices that do not exist");
        drop(malformed_, "face statements that cannot be read");
        drop(too_few_, "faces with fewer than three corners");
        drop(repeated_, "repeated corners of polygons");
        drop(bad_uvs_, "texture coordinates that do not exist");
        drop(bad_normals_, "normals that do not exist");
        drop(lines_, "line elements");
        drop(points_, "point elements");
        drop(free_forms_, "free-form elements");
        const auto warn = [&](const Tally& tally, const std::string& what) {
            if (tally.count > 0)
                out_.warnings.push_back(std::to_string(tally.count) + " " + what + ", first in line " +
                                        std::to_string(tally.first.line) + ", column " +
                                        std::to_string(tally.first.column));
        };
        warn(bad_numbers_, "numbers are missing or cannot be read and count as NaN");
        warn(bad_positions_, "faces name vertices that do not exist");
        warn(fans_, "polygons are flat or cross themselves and were split as fans");
        auto& files = out_.dependencies;
        std::sort(files.begin(), files.end());
        files.erase(std::unique(files.begin(), files.end()), files.end());
        std::set<std::string_view> seen;
        std::vector<std::string> unique;
        for (const std::string& warning : out_.warnings)
            if (seen.insert(warning).second && seen.size() <= kMaxWarnings) unique.push_back(warning);
        if (seen.size() > kMaxWarnings) unique.push_back(std::to_string(seen.size() - kMaxWarnings) + " more warnings");
        out_.warnings = std::move(unique);
    }

    const fs::path& path_;
    const MeshReadLimits& limits_;
    FileFinder finder_;
    ImportedMesh out_;
    const char* line_start_ = nullptr;
    Spot spot_;  ///< of the statement that is being read
    std::uint64_t triangles_ = 0;

    std::vector<Vec3d> positions_, normals_;
    std::vector<Vec2d> uvs_;
    std::vector<Colour> colours_;  ///< empty, or as far as the last coloured vertex
    std::vector<Corner> corners_;
    std::vector<Polygon> polygons_;

    std::uint32_t material_ = kAbsent;
    std::map<std::string, std::uint32_t, std::less<>> material_ids_;
    std::vector<std::string> material_names_, libraries_;  ///< in the order of first use
    MtlLibrary library_;
    std::vector<MtlMaterial> mtl_;  ///< beside out_.mesh.materials

    Tally bad_numbers_, bad_positions_, bad_uvs_, bad_normals_, malformed_, too_few_, repeated_, fans_;
    Tally lines_, points_, free_forms_;
};

}  // namespace

ImportedMesh read_obj(const fs::path& path, const MeshReadLimits& limits) {
    return ObjReader(path, limits).read();
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
