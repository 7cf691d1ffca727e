// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/map_stamp.cpp
#include "export/map_stamp.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <span>

#include "dgm/hash.h"
#include "mesh/source_inputs.h"
#include "model/error.h"

namespace dgm::exporter {
namespace {
namespace fs = std::filesystem;

constexpr std::size_t kHeadBytes = 4096, kTailBytes = 256;

/// At most `bytes` from the file's `start`.
std::string part_of(const fs::path& file, std::uint64_t start, std::size_t bytes) {
    std::ifstream stream(file, std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(start));
    std::string out(bytes, '\0');
    stream.read(out.data(), static_cast<std::streamsize>(bytes));
    out.resize(static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
    return out;
}

bool glb_carries(const fs::path& file, std::uint64_t size, const std::string& stamp) {
    const std::string head = part_of(file, 0, kHeadBytes);
    if (head.size() < 12 || !head.starts_with("glTF")) return false;
    std::uint32_t length = 0;
    std::memcpy(&length, head.data() + 8, sizeof length);
    return length == size && head.find("\"map\":\"" + stamp + "\"") != std::string::npos;
}

bool obj_carries(const fs::path& file, std::uint64_t size, const std::string& stamp) {
    const std::string tail = part_of(file, size - std::min<std::uint64_t>(size, kTailBytes), kTailBytes);
    if (!tail.ends_with("\n# " + stamp_comment(stamp) + "\n")) return false;
    const auto inputs = formats::source_inputs(file);
    return inputs && inputs->missing.empty();
}

bool ply_carries(const fs::path& file, std::uint64_t size, const std::string& stamp) {
    const std::string head = part_of(file, 0, kHeadBytes);
    const std::string comment = "\ncomment " + stamp_comment(stamp) + " ", end = "\nend_header\n";
    const std::size_t at = head.find(comment), behind = head.find(end);
    if (at == std::string::npos || behind == std::string::npos) return false;
    std::uint64_t bytes = 0;
    std::from_chars(head.data() + at + comment.size(), head.data() + head.size(), bytes);
    if (behind + end.size() + bytes != size) return false;
    const std::string picture = "\ncomment TextureFile ";
    const std::size_t named = head.find(picture);
    if (named == std::string::npos) return true;
    const std::size_t name = named + picture.size();
    return fs::is_regular_file(file.parent_path() / head.substr(name, head.find('\n', name) - name));
}
}  // namespace

std::string map_stamp(const model::MapSet& maps, std::string_view settings) {
    formats::Hasher hasher;
    for (const std::string_view text :
         {std::string_view(maps.generator), std::string_view(maps.report_json), settings}) {
        const std::uint64_t size = text.size();
        hasher.add(std::as_bytes(std::span(&size, 1)));
        hasher.add(std::as_bytes(std::span(text)));
    }
    hasher.add(std::as_bytes(std::span(maps.source_hash)));
    hasher.add(std::as_bytes(std::span(maps.settings_hash)));
    return formats::to_hex(hasher.result());
}

bool carries_stamp(const fs::path& file, const std::string& stamp) {
    try {
        if (!fs::is_regular_file(file)) return false;
        const std::uint64_t size = fs::file_size(file);
        const fs::path extension = file.extension();
        if (extension == ".glb") return glb_carries(file, size, stamp);
        if (extension == ".obj") return obj_carries(file, size, stamp);
        return extension == ".ply" && ply_carries(file, size, stamp);
    } catch (const fs::filesystem_error&) { return false; } catch (const model::Error&) {
        return false;
    }
}

std::string stamp_comment(const std::string& stamp) {
    return "map " + stamp;
}

}  // namespace dgm::exporter
