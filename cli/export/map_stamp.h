// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/map_stamp.h
// Which map a mesh file was made from, written into it, so that a bake need not make it again.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "model/map_set.h"

namespace dgm::exporter {

/// 32 hexadecimal digits that stand for a map and for how it was exported: XXH3-128 over the generator, the hashes of
/// source and settings, the report, and `settings`. Charts are not looked at: the head of a file will do.
[[nodiscard]] std::string map_stamp(const model::MapSet& maps, std::string_view settings = {});

/// True if `file` (.glb, .obj or .ply, as export_maps() writes them) carries `stamp`, is as long as it says, and the
/// files that it names are there. False for whatever cannot be read.
[[nodiscard]] bool carries_stamp(const std::filesystem::path& file, const std::string& stamp);

/// How the stamp stands in an OBJ's last line and in a PLY's header.
[[nodiscard]] std::string stamp_comment(const std::string& stamp);

}  // namespace dgm::exporter
