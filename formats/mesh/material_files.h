// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/material_files.h
// Finding the files that a mesh names: written on another machine, under another operating system, in another case.
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/asset_folders.h"

namespace dgm::formats {

/// A file that a mesh names, or why it is not read.
struct FoundFile {
    enum class Why { kMissing, kOutside, kSpecial };
    std::filesystem::path path;  ///< empty if it is not read
    Why why = Why::kMissing;
    explicit operator bool() const { return !path.empty(); }
    const std::filesystem::path& operator*() const { return path; }
};

/// "DGM3012: texture missing: skin.png; looked for beside the mesh, ...": the warnings of a file that is not read
/// (DGM3011 to DGM3014). They name no folder of this machine, since they go into the bake's report.
[[nodiscard]] std::string texture_missing(std::string_view name, FoundFile::Why why);
[[nodiscard]] std::string library_missing(std::string_view name, FoundFile::Why why);

/// Looks files up in the mesh's folder and the asset roots. Keeps folder listings, so it is cheap to ask often. Not
/// thread-safe.
class FileFinder {
 public:
    explicit FileFinder(const std::filesystem::path& mesh_file, std::span<const std::filesystem::path> asset_roots = {})
        : folders_(mesh_file, asset_roots) {}

    /// The regular file that `name` means: the path as it stands below the mesh's folder, else in another case, else
    /// as much of its end as is there ("C:\My Files\skins\a b.png" is skins/a b.png, or a b.png), else its last
    /// component in a folder beside the mesh called textures, texture, maps, images or materials, else, for absolute
    /// names, that very file; then the same below each asset root. URLs are decoded where the name as it stands leads
    /// nowhere. Backslashes are slashes, blanks belong to the name, quotes around it are dropped. Of several that
    /// differ in case the first in byte order is taken.
    ///
    /// A file outside those folders is not found, whether the name leads there or a link, nor is a pipe or a device:
    /// `why` tells. For a name that leads outside it does not depend on what is there.
    /// @throws model::Error kIoTrouble if the system failed for the moment
    [[nodiscard]] FoundFile find(std::string_view name);

 private:
    using Listing = std::map<std::string, std::vector<std::string>>;  ///< lower case -> names as they stand, sorted
    const Listing& listing(const std::filesystem::path& folder);
    bool may_read(const std::filesystem::path& file);
    std::optional<std::filesystem::path> find_as_it_stands(std::string path);
    std::optional<std::filesystem::path> find_in(const std::filesystem::path& folder, const std::string& path);
    std::optional<std::filesystem::path> find_below(const std::filesystem::path& folder, std::string_view relative);

    AssetFolders folders_;
    std::map<std::filesystem::path, Listing> listings_;
    FoundFile::Why why_ = FoundFile::Why::kMissing;  ///< of the search that goes on
};

}  // namespace dgm::formats
