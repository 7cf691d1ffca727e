// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/mesh_reader.cpp
#include "mesh/mesh_reader.h"

#include <fstream>
#include <string>
#include <system_error>

#include "mesh/assimp_reader.h"
#include "mesh/obj_reader.h"
#include "mesh/text_input.h"
#include "model/codes.h"
#include "model/file_errors.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;

/// The start of a file, to see whether it is OBJ where the extension does not say so.
std::string read_head(const fs::path& path, std::size_t most) {
    std::string head(most, '\0');
    std::ifstream file(path, std::ios::binary);
    file.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(file.gcount()));
    return head;
}

void check_file(const fs::path& path, const MeshReadLimits& limits) {
    std::error_code error;
    const auto status = fs::status(path, error);
    if (!fs::exists(status)) throw model::missing_file(path);
    if (!fs::is_regular_file(status)) throw model::no_regular_file(path).with_hint("name a mesh file");
    const std::uint64_t size = fs::file_size(path, error);
    if (error) throw model::unreadable_file(path, error.message());
    if (size == 0)
        throw model::Error(codes::kNoFaces, "the file is empty", path.string())
            .with_hint("copy or export it again: nothing is in it");
    if (size > limits.max_file_bytes)
        throw model::Error(codes::kTooLarge,
                           std::to_string(size) + " bytes; the limit is " + std::to_string(limits.max_file_bytes),
                           path.string());
}

/// assimp 5.2 reads on for ever where a PLY header has no end.
void check_ply_header(const fs::path& path) {
    constexpr std::size_t kMaxHeader = std::size_t{1} << 20;
    const std::string head = read_head(path, kMaxHeader);
    if (!head.starts_with("ply")) return;
    LineReader lines(head);
    std::string_view line;
    while (lines.next(line)) {
        if (trim(line) == "end_header") return;
    }
    throw model::Error(codes::kImportFailed, "the PLY header has no end_header", path.string());
}

}  // namespace

ImportedMesh read_mesh(const fs::path& path, const MeshReadLimits& limits) {
    check_file(path, limits);
    const std::string extension = lower_case(path.extension().string());
    if (extension == ".obj") return read_obj(path, limits);
    if (!assimp_knows_extension(extension) && looks_like_obj(read_head(path, std::size_t{1} << 16)))
        return read_obj(path, limits);
    check_ply_header(path);
    return read_with_assimp(path, limits);
}

}  // namespace dgm::formats
