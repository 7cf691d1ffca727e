// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/asset_folders.cpp
#include "mesh/asset_folders.h"

#include <system_error>

#include "files/io_failure.h"

namespace dgm::formats {
namespace {

namespace fs = std::filesystem;

/// `file` from `folder`; empty if it does not lie below it. Both as they are spelled.
fs::path below(const fs::path& file, const fs::path& folder) {
    fs::path out = file.lexically_relative(folder);
    return out.empty() || out.is_absolute() || *out.begin() == ".." ? fs::path() : out;
}

/// Without links; empty if it is not there.
fs::path real_path(const fs::path& path) {
    std::error_code error;
    fs::path out = fs::canonical(path, error);
    check_look(error, path);
    return error ? fs::path() : out;
}

}  // namespace

AssetFolders::AssetFolders(const fs::path& mesh_file, std::span<const fs::path> roots) {
    folders_.push_back(mesh_file.parent_path());
    folders_.insert(folders_.end(), roots.begin(), roots.end());
    for (const fs::path& folder : folders_) real_.push_back(real_path(folder.empty() ? fs::path(".") : folder));
}

bool AssetFolders::hold(const fs::path& file) const {
    const fs::path real = real_path(file);
    if (real.empty()) return false;
    for (const fs::path& folder : real_)
        if (!folder.empty() && !below(real, folder).empty()) return true;
    return false;
}

std::string AssetFolders::name_of(const fs::path& file) const {
    if (!hold(file)) return {};
    // As it is spelled, where that is below the mesh: a link that is set to another file keeps its name.
    fs::path name = below(file.lexically_normal(), folders_[0].lexically_normal());
    const fs::path real = real_path(file);
    for (std::size_t k = 0; name.empty() && k < real_.size(); ++k)
        if (!real_[k].empty()) name = below(real, real_[k]);
    return name.generic_string();
}

std::optional<fs::path> AssetFolders::resolve(std::string_view name) const {
    if (leads_outside(name)) return std::nullopt;
    for (const fs::path& folder : folders_) {
        fs::path file = folder / name;
        if (fs::is_regular_file(look_at(file)) && hold(file)) return file;
    }
    return std::nullopt;
}

bool leads_outside(std::string_view name) {
    const fs::path normal = fs::path(name).lexically_normal();
    return normal.is_absolute() || (!normal.empty() && *normal.begin() == "..");
}

bool is_special_file(const fs::path& path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    return fs::is_fifo(status) || fs::is_socket(status) || fs::is_character_file(status) || fs::is_block_file(status);
}

}  // namespace dgm::formats
