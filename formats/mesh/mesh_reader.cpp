// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/mesh_reader.cpp
#include "mesh/mesh_reader.h"

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "files/regular_file.h"
#include "mesh/assimp_reader.h"
#include "mesh/obj_reader.h"
#include "mesh/text_input.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;

/// The start of a file, to see whether it is OBJ where the extension does not say so.
std::string read_head(const fs::path& path, std::size_t most) {
    std::string head(most, '\0');
    head.resize(RegularFile(path).read(std::as_writable_bytes(std::span(head))));
    return head;
}

/// assimp makes room for all that a header promises. @param elements  vertices, faces and the like
void check_promise(double elements, std::uintmax_t bytes, const fs::path& path) {
    if (elements <= static_cast<double>(bytes)) return;  // each takes a byte at least
    throw model::Error(codes::kImportFailed,
                       "the header promises more vertices and faces than " + std::to_string(bytes) + " bytes can hold",
                       path.string())
        .with_hint("the file is cut off or damaged: copy or export it again");
}

/// assimp 5.2 reads on for ever where a PLY header has no end, and believes its numbers.
void check_ply_header(const fs::path& path) {
    constexpr std::size_t kMaxHeader = std::size_t{1} << 20;
    const std::string head = read_head(path, kMaxHeader);
    if (!head.starts_with("ply")) return;
    LineReader lines(head);
    std::string_view line;
    double promised = 0, elements = 0;  // those of the last kind count once it has a property
    while (lines.next(line)) {
        const std::string_view first = next_word(line);
        if (first == "end_header") return check_promise(promised, RegularFile(path).size(), path);
        if (first == "element") {
            static_cast<void>(next_word(line));  // its name
            elements = parse_number(next_word(line)).value_or(0);
        } else if (first == "property") {
            promised += std::exchange(elements, 0);
        }
    }
    throw model::Error(codes::kImportFailed, "the PLY header has no end_header", path.string());
}

/// The numbers of vertices and faces in the first line that has two numbers, behind words such as OFF.
void check_off_header(std::string_view text, const fs::path& path) {
    LineReader lines(text);
    std::string_view line;
    while (lines.next(line)) {
        line = line.substr(0, line.find('#'));
        std::string_view word = next_word(line);
        if (word.ends_with("OFF")) word = next_word(line);
        if (word.empty()) continue;
        const std::optional<double> vertices = parse_number(word), faces = parse_number(next_word(line));
        if (vertices && faces) check_promise(*vertices + *faces, text.size(), path);
        return;
    }
}

/// assimp 5.2 reads OFF files through a buffer of 4096 bytes a line, and crashes on faces that do not fit.
void check_off(const fs::path& path, const MeshReadLimits& limits) {
    constexpr std::size_t kLine = 4096;
    const std::string text = RegularFile(path).read_text(limits.max_file_bytes);
    check_off_header(text, path);
    std::size_t number = 1;
    for (std::size_t begin = 0; begin < text.size(); ++number) {
        const std::size_t end = std::min(text.find_first_of("\r\n", begin), text.size());
        if (end - begin >= kLine)
            throw model::Error(codes::kImportFailed,
                               "a line of " + std::to_string(end - begin) + " bytes; OFF files are read up to " +
                                   std::to_string(kLine - 1),
                               path.string() + ":" + std::to_string(number))
                .with_hint("split polygons of hundreds of corners, or export the mesh as OBJ or PLY");
        begin = end + (text.compare(end, 2, "\r\n") == 0 ? 2 : 1);
    }
}

}  // namespace

void check_mesh_file(const fs::path& path, const MeshReadLimits& limits) {
    try {
        const RegularFile file(path);
        file.check_size(limits.max_file_bytes);
        if (file.size() == 0)
            throw model::Error(codes::kNoFaces, "the file is empty", path.string())
                .with_hint("copy or export it again: nothing is in it");
    } catch (model::Error& error) {
        std::error_code ignored;
        if (error.code().number != codes::kReadFailed.number || fs::is_regular_file(path, ignored)) throw;
        throw error.with_hint("name a mesh file");
    }
}

ImportedMesh read_mesh(const fs::path& path, const MeshReadLimits& limits) {
    check_mesh_file(path, limits);
    const std::string extension = lower_case(path.extension().string());
    if (extension == ".obj") return read_obj(path, limits);
    if (!assimp_knows_extension(extension) && looks_like_obj(read_head(path, std::size_t{1} << 16)))
        return read_obj(path, limits);
    check_ply_header(path);
    if (extension == ".off") check_off(path, limits);
    return read_with_assimp(path, limits);
}

}  // namespace dgm::formats
