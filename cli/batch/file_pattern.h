// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/file_pattern.h
// File name patterns with `*`, `?`, `[...]` and `**`, for where no shell has expanded them.
#pragma once
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

namespace dgm::bake {

/// True if the text holds a wildcard.
[[nodiscard]] bool is_pattern(std::string_view text);

/// The folder in front of the first wildcard (empty: the current one), and the relative paths of the regular files
/// below it that match, in byte order. A component `**` matches any number of folders, none too; the others match one
/// name each, as fnmatch(3) does. Hidden names match only where the pattern has the dot; links to folders are not
/// followed. @throws model::Error if a folder cannot be listed, as formats::files_below()
[[nodiscard]] std::pair<std::filesystem::path, std::vector<std::filesystem::path>> files_matching(
    const std::filesystem::path& pattern);

}  // namespace dgm::bake
