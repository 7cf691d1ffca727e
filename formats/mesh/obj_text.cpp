// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/obj_text.cpp
// [OBJ] Alias|Wavefront. Object files (.obj), version 3.0. Advanced Visualizer manual, appendix B1.
#include "mesh/obj_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <span>

#include "mesh/text_input.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

using model::Vec3d;

Vec3d unit_or_zero(const Vec3d& n) {
    const double largest = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
    if (!is_finite(n) || !(largest > 0)) return {0, 0, 0};
    return normalized(n / largest, {0, 0, 0});
}

/// One index of a corner: 1 is the first, -1 the last so far.
std::uint32_t resolve(std::int64_t index, std::size_t so_far) {
    if (index > 0) return index <= std::int64_t{kObjInvalid} ? static_cast<std::uint32_t>(index - 1) : kObjInvalid;
    const std::int64_t from_end = static_cast<std::int64_t>(so_far) + index;
    return index < 0 && from_end >= 0 ? static_cast<std::uint32_t>(from_end) : kObjInvalid;
}

class Parser {
 public:
    Parser(const std::filesystem::path& path, const MeshReadLimits& limits) : path_(path), limits_(limits) {}

    ObjText parse(std::string_view text) {
        LineReader lines(text);
        std::string_view line;
        while (lines.next(line)) {
            line_start_ = line.data();
            spot_.line = lines.number();
            read_statement(line);
        }
        return std::move(out_);
    }

 private:
    /// Place of a word in the current line.
    [[nodiscard]] ObjSpot spot_of(std::string_view word) const {
        return {spot_.line, static_cast<std::uint64_t>(word.data() - line_start_) + 1};
    }

    void read_statement(std::string_view line) {
        const std::string_view word = next_word(line);
        if (word.empty() || word.front() == '#') return;
        spot_ = spot_of(word);
        if (word == "v") {
            read_position(line);
        } else if (word == "vt") {
            double uv[2] = {0, 0};
            read_numbers(line, uv);
            out_.uvs.push_back({uv[0], uv[1]});
        } else if (word == "vn") {
            double n[3] = {0, 0, 0};
            read_numbers(line, n);
            out_.normals.push_back(unit_or_zero({n[0], n[1], n[2]}));
        } else if (word == "f" || word == "fo") {
            read_face(line);
        } else if (word == "usemtl") {
            use_material(trim(line));
        } else if (word == "mtllib") {
            out_.libraries.emplace_back(trim(line));
        } else if (word == "l") {
            out_.tallies.lines.add(spot_);
        } else if (word == "p") {
            out_.tallies.points.add(spot_);
        } else if (word == "curv" || word == "curv2" || word == "surf") {
            out_.tallies.free_forms.add(spot_);
        }
    }

    /// Fills `values` from the words of the line as far as they go; a word that is no number becomes NaN.
    std::size_t read_numbers(std::string_view line, std::span<double> values) {
        std::size_t count = 0;
        while (count < values.size()) {
            const std::string_view word = next_word(line);
            if (word.empty() || word.front() == '#') break;
            const auto number = parse_number(word);
            if (!number) out_.tallies.bad_numbers.add(spot_of(word));
            values[count++] = number.value_or(std::numeric_limits<double>::quiet_NaN());
        }
        return count;
    }

    void read_position(std::string_view line) {
        constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
        double x[7] = {kNan, kNan, kNan, 1, 1, 1, 1};
        const std::size_t count = read_numbers(line, x);
        if (count < 3) out_.tallies.bad_numbers.add(spot_);
        Vec3d position{x[0], x[1], x[2]};
        if (count == 4 && x[3] != 1 && x[3] != 0 && std::isfinite(x[3])) position = position / x[3];
        if (out_.positions.size() >= limits_.max_vertices) too_large("vertices", limits_.max_vertices);
        out_.positions.push_back(position);
        if (count < 6) return;
        out_.colours.resize(out_.positions.size());
        out_.colours.back() = {x[3], x[4], x[5], count == 7 ? x[6] : -1};
    }

    void use_material(std::string_view name) {
        const auto [entry, is_new] =
            material_ids_.try_emplace(std::string(name), static_cast<std::uint32_t>(out_.material_names.size()));
        if (is_new) out_.material_names.push_back(entry->first);
        material_ = entry->second;
    }

    /// "7", "7/8", "7//9", "7/8/9"; nothing if the word is none of them.
    std::optional<ObjCorner> parse_corner(std::string_view word) const {
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
        ObjCorner corner;
        corner.position = resolve(index[0], out_.positions.size());
        if (present[1]) corner.uv = resolve(index[1], out_.uvs.size());
        if (present[2]) corner.normal = resolve(index[2], out_.normals.size());
        return corner;
    }

    void read_face(std::string_view line) {
        const std::size_t first = out_.corners.size();
        for (std::string_view word = next_word(line); !word.empty() && word.front() != '#'; word = next_word(line)) {
            const auto corner = parse_corner(word);
            if (!corner) {
                out_.tallies.malformed.add(spot_of(word));
                out_.corners.resize(first);
                return;
            }
            out_.corners.push_back(*corner);
        }
        const std::size_t size = out_.corners.size() - first;
        if (size < 3) {
            out_.tallies.too_few.add(spot_);
            out_.corners.resize(first);
            return;
        }
        out_.triangles += size - 2;
        if (out_.triangles > limits_.max_faces) too_large("faces", limits_.max_faces);
        out_.polygons.push_back(
            {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(size), material_, spot_});
    }

    [[noreturn]] void too_large(const std::string& what, std::uint64_t limit) const {
        throw model::Error(model::codes::kTooLarge, "more than " + std::to_string(limit) + " " + what,
                           obj_place(path_, spot_));
    }

    const std::filesystem::path& path_;
    const MeshReadLimits& limits_;
    ObjText out_;
    const char* line_start_ = nullptr;
    ObjSpot spot_;  // of the statement that is being read
    std::uint32_t material_ = kObjAbsent;
    std::map<std::string, std::uint32_t, std::less<>> material_ids_;
};

}  // namespace

std::string obj_place(const std::filesystem::path& path, const ObjSpot& spot) {
    return path.string() + ":" + std::to_string(spot.line) + ":" + std::to_string(spot.column);
}

ObjText parse_obj(std::string_view text, const std::filesystem::path& path, const MeshReadLimits& limits) {
    return Parser(path, limits).parse(text);
}

}  // namespace dgm::formats
