// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/material_files.h
// Finding the files that a mesh names: written on another machine, under another operating system, in another case.
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dgm::formats {

/// Looks files up relative to one folder. Keeps folder listings, so it is cheap to ask often. Not thread-safe.
class FileFinder {
 public:
    explicit FileFinder(const std::filesystem::path& mesh_file) : folder_(mesh_file.parent_path()) {}

    /// The regular file that `name` means: the path as it stands below the mesh's folder, else in another case, else
    /// its last component in the mesh's folder or in a folder beside it called textures, texture, maps, images or
    /// materials, else, for absolute names, that very file. Backslashes are slashes, quotes around the name are
    /// dropped. Of several that differ in case the first in byte order is taken.
    [[nodiscard]] std::optional<std::filesystem::path> find(std::string_view name);

 private:
    using Listing = std::map<std::string, std::vector<std::string>>;  ///< lower case -> names as they stand, sorted
    const Listing& listing(const std::filesystem::path& folder);
    std::optional<std::filesystem::path> find_below(const std::filesystem::path& folder, std::string_view relative);

    std::filesystem::path folder_;
    std::map<std::filesystem::path, Listing> listings_;
};

}  // namespace dgm::formats
