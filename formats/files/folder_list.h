// SPDX-License-Identifier: GPL-3.0-or-later
// formats/files/folder_list.h
// What lies in a folder. A list that ends early is an error: whoever goes on with half of it leaves assets out without
// a word.
#pragma once
#include <filesystem>
#include <vector>

namespace dgm::formats {

/// The regular files below `folder`, relative to it, in byte order. Hidden files and what is in hidden folders (a dot
/// in front) are left out, among them the staging folders of programs that run now; links to folders are not followed.
/// @param options  skip_permission_denied to pass over folders that may not be listed
/// @throws model::Error with read_failure() if it, or a folder below, cannot be listed
[[nodiscard]] std::vector<std::filesystem::path> files_below(
    const std::filesystem::path& folder,
    std::filesystem::directory_options options = std::filesystem::directory_options::none);

/// Byte order, whatever the components.
void sort_paths(std::vector<std::filesystem::path>& paths);

/// For what a look at a folder gave: nothing where there is no such folder.
/// @throws model::Error with read_failure() if it is there and cannot be listed
void check_listed(const std::error_code& error, const std::filesystem::path& folder);

}  // namespace dgm::formats
