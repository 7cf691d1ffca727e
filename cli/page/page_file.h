// SPDX-License-Identifier: GPL-3.0-or-later
// cli/page/page_file.h
// Maps, runtime and viewer as one page that opens from disk and asks for nothing else.
#pragma once
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "model/map_set.h"

namespace dgm::page {

struct PagedMap {
    std::string name;  ///< shown in the list of maps
    const model::MapSet* maps = nullptr;
};

/// A recorded tool path; one whose name begins with that of a map is offered for that map alone.
struct PagedPath {
    std::string name;  ///< shown in the list of paths, with spaces for underscores
    std::string text;  ///< as formats/path has it
};

struct PageSettings {
    std::string title;
    bool z_is_up = false;
    std::vector<PagedPath> paths;
    std::vector<std::byte> still;  ///< JPEG, for browsers that cannot draw the surface; may be empty
};

/// The text of a page in which `maps` are turned and touched; without any, one that maps are dropped on. Same maps,
/// same bytes. `scratch` is a file that may be written.
/// @throws model::Error kUnsupported in a build without the runtime for pages; as packed_map()
[[nodiscard]] std::string page_file(const PageSettings& settings, std::span<const PagedMap> maps,
                                    const std::filesystem::path& scratch);

}  // namespace dgm::page
