// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_files.h
// Which files one geometry map is in OpenEXR: one of the grid, and one for each layer of another size.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace dgm::formats {

enum class ExrLayout {
    kAuto,       ///< one part for everything grid-sized
    kMultipart,  ///< one part a layer, named like it
};

/// Where a file of layers stands beside the map's own: `a.exr` and `texture` give `a.texture.exr`. A name with another
/// ending keeps it: `a.tmp` gives `a.tmp.texture`.
[[nodiscard]] std::filesystem::path exr_side_path(const std::filesystem::path& map, std::string_view name);

/// True if the file holds layers of a map that is described in another file. Never throws; false for what is no EXR.
[[nodiscard]] bool is_exr_side_file(const std::filesystem::path& path) noexcept;

/// Names of the files of layers beside a map, as exr_side_path takes them; none if it cannot be read.
[[nodiscard]] std::vector<std::string> exr_side_names(const std::filesystem::path& map);

/// After another map was put in the place of one: removes the files of layers that the old one had (`old_names`) and
/// the new one has not.
void remove_old_exr_sides(const std::filesystem::path& map, const std::vector<std::string>& old_names);

/// For the name of a file of layers that is about to be written: refuses if another file has it.
/// @throws model::Error kWriteFailed
void check_exr_side_place(const std::filesystem::path& path);

}  // namespace dgm::formats
