// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/asset_folders.h
// Where the files that a mesh names may lie: a mesh from elsewhere must not read what else is on this machine.
#pragma once
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace dgm::formats {

/// The folder of a mesh, and the asset roots that the user allows beside it.
/// Its functions throw model::Error kIoTrouble where the system fails for the moment: a file that is there must not
/// look like one that is not.
class AssetFolders {
 public:
    explicit AssetFolders(const std::filesystem::path& mesh_file, std::span<const std::filesystem::path> roots = {});

    /// The mesh's folder, then the asset roots, as they were given.
    [[nodiscard]] const std::vector<std::filesystem::path>& all() const { return folders_; }

    /// True if `file` is there and lies, all links followed, in one of the folders or below.
    [[nodiscard]] bool hold(const std::filesystem::path& file) const;

    /// The name of a file that they hold, for reports and for resolve(): from the mesh's folder, else from the first
    /// root that holds it. Empty if they do not hold it. It says nothing about where the folders are.
    [[nodiscard]] std::string name_of(const std::filesystem::path& file) const;

    /// The regular file that a name_of() means now, if there is one.
    [[nodiscard]] std::optional<std::filesystem::path> resolve(std::string_view name) const;

 private:
    std::vector<std::filesystem::path> folders_;
    std::vector<std::filesystem::path> real_;  ///< the same without links; empty for those that are not there
};

/// True if a name such as "../a.png" or "/home/a.png" cannot mean a file below the folder it is taken from.
[[nodiscard]] bool leads_outside(std::string_view name);

/// True for pipes, sockets and devices: opening them may wait for ever.
[[nodiscard]] bool is_special_file(const std::filesystem::path& path);

}  // namespace dgm::formats
