// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/source_inputs.cpp
// [3DS] Autodesk 3D Studio File Toolkit, release 2: chunks of a 16-bit id and a 32-bit length that counts the header.
#include "mesh/source_inputs.h"

#include <algorithm>
#include <string_view>

#include "mesh/material_files.h"
#include "mesh/mesh_reader.h"
#include "mesh/mtl_reader.h"
#include "mesh/text_input.h"

namespace dgm::formats {
namespace {

namespace fs = std::filesystem;

/// The places where `word` (lower case) stands in `text`, in any case, at the start of a line but for blanks.
std::vector<std::size_t> line_starts(std::string_view text, std::string_view word) {
    std::vector<std::size_t> out;
    const char first[] = {word.front(), static_cast<char>(word.front() - 'a' + 'A')};
    for (const char letter : first) {
        for (std::size_t at = text.find(letter); at != std::string_view::npos; at = text.find(letter, at + 1)) {
            if (text.size() - at < word.size() || lower_case(text.substr(at, word.size())) != word) continue;
            std::size_t begin = at;
            while (begin > 0 && (text[begin - 1] == ' ' || text[begin - 1] == '\t')) --begin;
            if (begin == 0 || text[begin - 1] == '\n' || text[begin - 1] == '\r') out.push_back(at);
        }
    }
    std::sort(out.begin(), out.end());
    return out;
}

SourceInputs inputs_of_obj(const fs::path& path, std::span<const fs::path> asset_roots) {
    const std::string text = read_text_file(path, MeshReadLimits{}.max_file_bytes);
    std::vector<std::string> statements;
    std::size_t taken = 0;  // a line that goes on behind a backslash is read once
    for (const std::size_t at : line_starts(text, "mtllib")) {
        if (at < taken) continue;
        LineReader lines(std::string_view(text).substr(at));
        std::string_view line;
        if (lines.next(line) && lower_case(next_word(line)) == "mtllib") statements.emplace_back(trim(line));
        taken = text.size() - lines.rest().size();
    }
    SourceInputs out;
    FileFinder finder(path, asset_roots);
    MtlLibrary library;
    read_mtl_libraries(statements, finder, library, out.missing, out.files);
    return out;
}

constexpr unsigned kMain = 0x4D4D, kEditor = 0x3D3D, kMaterial = 0xAFFF, kMapName = 0xA300;

/// The maps of a material: texture 1 and 2, opacity, bump, specular, shininess, self-illumination, reflection, and
/// their masks. They, and the chunks above them, contain chunks and nothing else before them.
bool holds_chunks(unsigned id) {
    return id == kMain || id == kEditor || id == kMaterial || (id >= 0xA200 && id < 0xA250) ||
           (id >= 0xA33A && id < 0xA350);
}

std::vector<std::string> map_names(std::string_view bytes) {
    const auto number = [&](std::size_t at, int count) {
        std::uint32_t value = 0;
        for (int k = 0; k < count; ++k)
            value |= std::uint32_t{static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(k)])} << (8 * k);
        return value;
    };
    constexpr std::size_t kHeader = 6;
    std::vector<std::string> out;
    // A chunk that holds chunks is entered, any other is passed over: one walk without recursion.
    for (std::size_t at = 0; bytes.size() - at >= kHeader;) {
        const unsigned id = number(at, 2);
        const std::size_t length = number(at + 2, 4);
        if (length < kHeader || length > bytes.size() - at) break;
        if (id == kMapName) {
            const std::string_view body = bytes.substr(at + kHeader, length - kHeader);
            out.emplace_back(body.substr(0, body.find('\0')));
        }
        at += holds_chunks(id) ? kHeader : length;
    }
    return out;
}

SourceInputs inputs_of_3ds(const fs::path& path, std::span<const fs::path> asset_roots) {
    SourceInputs out;
    FileFinder finder(path, asset_roots);
    for (const std::string& name : map_names(read_text_file(path, MeshReadLimits{}.max_file_bytes))) {
        if (name.empty()) continue;
        if (const auto found = finder.find(name))
            out.files.push_back(*found);
        else
            out.missing.push_back(texture_missing(name, found.why));
    }
    return out;
}

}  // namespace

std::optional<SourceInputs> source_inputs(const fs::path& mesh_file, std::span<const fs::path> asset_roots) {
    const std::string extension = lower_case(mesh_file.extension().string());
    SourceInputs out;
    if (extension == ".obj")
        out = inputs_of_obj(mesh_file, asset_roots);
    else if (extension == ".3ds")
        out = inputs_of_3ds(mesh_file, asset_roots);
    else if (extension != ".ply" && extension != ".stl" && extension != ".off")
        return std::nullopt;
    std::sort(out.files.begin(), out.files.end());
    out.files.erase(std::unique(out.files.begin(), out.files.end()), out.files.end());
    return out;
}

}  // namespace dgm::formats
