// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_files.cpp
#include "exr/exr_files.h"

#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <exception>
#include <system_error>

#include "exr/exr_attributes.h"
#include "exr/exr_headers.h"
#include "exr/exr_reader.h"
#include "model/codes.h"

namespace dgm::formats {

namespace fs = std::filesystem;

fs::path exr_side_path(const fs::path& map, std::string_view name) {
    fs::path out = map;
    if (map.extension() == ".exr") out.replace_extension();
    out += "." + std::string(name);
    if (map.extension() == ".exr") out += ".exr";
    return out;
}

bool is_exr_side_file(const fs::path& path) noexcept {
    try {
        std::error_code error;
        if (!fs::is_regular_file(path, error)) return false;
        const std::uint64_t bytes = fs::file_size(path, error);
        if (error) return false;
        constexpr std::uint64_t kAny = ~std::uint64_t{0} >> 1;
        check_exr_headers(path, bytes, kAny, 1 << 20, kAny);
        const Imf::MultiPartInputFile file(path.c_str(), 0, false);
        return file.header(0).findTypedAttribute<Imf::StringAttribute>(kSideFileAttribute) != nullptr;
    } catch (const std::exception&) { return false; }
}

std::vector<std::string> exr_side_names(const fs::path& map) {
    try {
        return read_exr_head(map).beside;
    } catch (const model::Error&) { return {}; }
}

void remove_old_exr_sides(const fs::path& map, const std::vector<std::string>& old_names) {
    const std::vector<std::string> names = exr_side_names(map);
    std::error_code ignored;
    for (const std::string& name : old_names) {
        const fs::path side = exr_side_path(map, name);
        if (std::find(names.begin(), names.end(), name) == names.end() && is_exr_side_file(side))
            fs::remove(side, ignored);
    }
}

void check_exr_side_place(const fs::path& path) {
    std::error_code error;
    if (fs::exists(path, error) && !is_exr_side_file(path))
        throw model::Error(model::codes::kWriteFailed, "the name for layers of another size is taken by another file",
                           path.string());
}

}  // namespace dgm::formats
