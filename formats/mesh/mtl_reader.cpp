// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/mtl_reader.cpp
// [MTL] Ramey, Rose, Tyerman. MTL material format (Lightwave, OBJ). Alias|Wavefront 1995.
#include "mesh/mtl_reader.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "files/regular_file.h"
#include "mesh/text_input.h"
#include "model/shortage.h"

namespace dgm::formats {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMaxMtlBytes = std::uint64_t{64} << 20;

struct MapStatement {
    std::string file;
    model::Vec2d scale{1, 1}, offset{0, 0};
    double bump = 1;
};

/// How many words follow an option of a map statement [MTL, section "Options for texture map statements"]; 3 means one
/// to three numbers.
int option_words(std::string_view option) {
    if (option == "-o" || option == "-s" || option == "-t") return 3;
    if (option == "-mm") return 2;
    for (const char* one :
         {"-blendu", "-blendv", "-boost", "-texres", "-clamp", "-bm", "-imfchan", "-type", "-cc", "-colorspace"})
        if (option == one) return 1;
    return 0;
}

MapStatement parse_map(std::string_view rest) {
    MapStatement out;
    while (true) {
        std::string_view ahead = rest;
        const std::string option = lower_case(next_word(ahead));
        const int words = option.starts_with('-') ? option_words(option) : 0;
        if (words == 0) break;
        if (words == 1) {
            const std::string_view value = next_word(ahead);
            if (option == "-bm") out.bump = parse_number(value).value_or(1);
        } else if (words == 2) {
            (void)next_word(ahead);
            (void)next_word(ahead);
        } else {
            double values[3] = {0, 0, 0};
            if (option == "-s") values[0] = values[1] = values[2] = 1;
            for (double& value : values) {
                std::string_view after = ahead;
                const auto number = parse_number(next_word(after));
                // A file may be called "1"; the words after an option must leave a name.
                if (!number || trim(after).empty()) break;
                value = std::isfinite(*number) ? *number : value;
                ahead = after;
            }
            if (option == "-s") out.scale = {values[0], values[1]};
            if (option == "-o") out.offset = {values[0], values[1]};
        }
        rest = ahead;
    }
    out.file = std::string(trim(rest));
    if (!std::isfinite(out.bump)) out.bump = 1;
    return out;
}

class MtlReader {
 public:
    MtlReader(FileFinder& finder, MtlLibrary& library, std::vector<std::string>& warnings,
              std::vector<fs::path>& dependencies)
        : finder_(finder), library_(library), warnings_(warnings), dependencies_(dependencies) {}

    void read(std::string_view text) {
        LineReader lines(text);
        std::string_view line;
        while (lines.next(line)) statement(line);
        finish();
    }

 private:
    void statement(std::string_view line) {
        const std::string word = lower_case(next_word(line));
        if (word.empty() || word.front() == '#') return;
        if (word == "newmtl") {
            finish();
            current_.emplace();
            current_->material.name = std::string(trim(line));
        } else if (!current_) {
            return;
        } else if (word == "kd") {
            read_diffuse(line);
        } else if (word == "d") {
            std::string_view value = next_word(line);
            if (lower_case(value) == "-halo") value = next_word(line);
            if (const auto number = parse_number(value)) dissolve_ = *number;
        } else if (word == "tr") {
            if (const auto number = parse_number(next_word(line))) transparency_ = *number;
        } else if (word == "map_kd") {
            const MapStatement map = parse_map(line);
            current_->material.diffuse_map.path = find(map.file);
            current_->uv_scale = map.scale;
            current_->uv_offset = map.offset;
        } else if (word == "map_bump" || word == "bump" || word == "norm" || word == "map_kn") {
            read_bump(parse_map(line), word == "norm" || word == "map_kn");
        }
    }

    void read_diffuse(std::string_view line) {
        std::string_view first = next_word(line);
        // "Kd spectral FILE" and "Kd xyz X Y Z" name colours in ways that no exporter writes; they stay white.
        const auto r = parse_number(first);
        if (!r) return;
        const double red = *r;
        const double green = parse_number(next_word(line)).value_or(red);
        const double blue = parse_number(next_word(line)).value_or(red);
        auto& colour = current_->material.diffuse;
        colour = {byte_of_unit(red), byte_of_unit(green), byte_of_unit(blue), colour.a};
    }

    void read_bump(const MapStatement& map, bool is_normal_map) {
        const fs::path file = find(map.file);
        auto& material = current_->material;
        // A height map is worth more to a bake than a normal map: it says how far.
        if (file.empty() || (is_normal_map && !material.bump_map.empty() && !material.bump_is_normal_map)) return;
        material.bump_map.path = file;
        material.bump_is_normal_map = is_normal_map || is_normal_map_name(file);
        material.bump_scale = map.bump;
    }

    fs::path find(const std::string& name) {
        if (name.empty()) return {};
        const FoundFile found = finder_.find(name);
        if (found)
            dependencies_.push_back(*found);
        else
            warnings_.push_back(texture_missing(name, found.why));
        return *found;
    }

    void finish() {
        if (!current_) return;
        // d counts before Tr. Exporters of 3ds Max wrote "Tr 1" for opaque materials, and a wholly invisible one would
        // not be in the file: that value is not believed.
        double alpha = 1;
        if (dissolve_) {
            alpha = *dissolve_;
        } else if (transparency_ && *transparency_ < 1) {
            alpha = 1 - *transparency_;
        }
        current_->material.diffuse.a = byte_of_unit(alpha);
        std::string name = current_->material.name;
        library_.try_emplace(std::move(name), std::move(*current_));
        current_.reset();
        dissolve_.reset();
        transparency_.reset();
    }

    FileFinder& finder_;
    MtlLibrary& library_;
    std::vector<std::string>& warnings_;
    std::vector<fs::path>& dependencies_;
    std::optional<MtlMaterial> current_;
    std::optional<double> dissolve_, transparency_;
};

}  // namespace

void read_mtl(const fs::path& path, FileFinder& finder, MtlLibrary& library, std::vector<std::string>& warnings,
              std::vector<fs::path>& dependencies) {
    MtlReader(finder, library, warnings, dependencies).read(read_text_file(path, kMaxMtlBytes));
}

void read_mtl_libraries(std::span<const std::string> statements, FileFinder& finder, MtlLibrary& library,
                        std::vector<std::string>& warnings, std::vector<fs::path>& dependencies) {
    // A library is read once, however often and by whatever names a mesh asks for it.
    std::set<std::pair<std::uint64_t, std::uint64_t>> read;
    std::map<std::string, FoundFile, std::less<>> asked;
    const auto find_library = [&](std::string_view name) {
        FoundFile found = finder.find(name);
        if (!found) return found;
        dependencies.push_back(*found);
        try {
            if (read.insert(RegularFile(*found).identity()).second)
                read_mtl(*found, finder, library, warnings, dependencies);
        } catch (const model::Error& error) {  // as one that is not there: the shape can be baked all the same
            if (model::may_pass(error)) throw;
            warnings.push_back(error.code().id() + ": material library left out: " + std::string(name) + ": " +
                               error.what());
        }
        return found;
    };
    const auto read_library = [&](std::string_view name) {
        const auto known = asked.find(name);
        return known != asked.end() ? known->second : asked.emplace(name, find_library(name)).first->second;
    };
    std::set<std::string_view> seen;
    for (const std::string& statement : statements) {
        if (!seen.insert(statement).second) continue;
        const FoundFile whole = read_library(statement);
        if (whole) continue;
        // Not one name with spaces: then several names.
        std::string_view rest = statement;
        std::size_t words = 0, found = 0;
        for (std::string_view name = next_word(rest); !name.empty(); name = next_word(rest)) {
            ++words;
            const FoundFile one = read_library(name);
            if (one)
                ++found;
            else if (words > 1 || !trim(rest).empty())
                warnings.push_back(library_missing(name, one.why));
        }
        if (words == 1 && found == 0) warnings.push_back(library_missing(statement, whole.why));
    }
}

bool is_normal_map_name(const fs::path& file) {
    const std::string stem = lower_case(file.stem().string());
    if (stem.find("normal") != std::string::npos) return true;
    for (const char* end : {"_nrm", "_nor", "_nm", "_norm", "-nrm", "_n"})
        if (stem.ends_with(end)) return true;
    return false;
}

std::uint8_t byte_of_unit(double value) {
    if (std::isnan(value)) return 255;
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 1.0) * 255));
}

}  // namespace dgm::formats
