// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/file_list.h
// Names on the command line to files: patterns that the shell left alone, and folders.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace dgm::validate {

/// Each name in turn: a file is itself, whether it exists or not; a folder stands for the .dgm and .exr files below it;
/// a name with `*` or `?` that is no file is a pattern. `*` and `?` stop at a slash, `**` does not. What a folder or
/// pattern gives is sorted; a name without result stays, to be reported as missing. A file that is named twice is
/// listed once, and an EXR with layers of another that is listed, not at all. Hidden files are none of a folder's.
/// @throws model::Error if a folder cannot be listed: the verdict would be one of a part
[[nodiscard]] std::vector<std::filesystem::path> expand_names(const std::vector<std::string>& names);

/// True if the whole text fits the pattern.
[[nodiscard]] bool matches(std::string_view pattern, std::string_view text);

}  // namespace dgm::validate
