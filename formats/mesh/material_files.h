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

/// "DGM3012: texture missing: skin.png; looked for beside the mesh, ...": the warnings of a file that FileFinder does
/// not find. They name no folder of this machine, since they go into the bake's report.
[[nodiscard]] std::string texture_missing(std::string_view name);
[[nodiscard]] std::string library_missing(std::string_view name);

/// Looks files up relative to one folder. Keeps folder listings, so it is cheap to ask often. Not thread-safe.
class FileFinder {
 public:
    explicit FileFinder(const std::filesystem::path& mesh_file) : folder_(mesh_file.parent_path()) {}

    /// The regular file that `name` means: the path as it stands below the mesh's folder, else in another case, else
    /// as much of its end as is there ("C:\My Files\skins\a b.png" is skins/a b.png, or a b.png), else its last
    /// component in a folder beside the mesh called textures, texture, maps, images or materials, else, for absolute
    /// names, that very file. URLs are decoded where the name as it stands leads nowhere. Backslashes are slashes,
    /// blanks belong to the name, quotes around it are dropped. Of several that differ in case the first in byte order
    /// is taken.
    [[nodiscard]] std::optional<std::filesystem::path> find(std::string_view name);

 private:
    using Listing = std::map<std::string, std::vector<std::string>>;  ///< lower case -> names as they stand, sorted
    const Listing& listing(const std::filesystem::path& folder);
    std::optional<std::filesystem::path> find_as_it_stands(std::string path);
    std::optional<std::filesystem::path> find_below(const std::filesystem::path& folder, std::string_view relative);

    std::filesystem::path folder_;
    std::map<std::filesystem::path, Listing> listings_;
};

}  // namespace dgm::formats
