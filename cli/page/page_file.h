// SPDX-License-Identifier: GPL-3.0-or-later
// cli/page/page_file.h
// Maps, runtime and viewer as one page that opens from disk and asks for nothing else.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/map_set.h"
#include "model/tri_mesh.h"

namespace dgm::page {

/// Numbers of a chart's samples, border samples last, in 256 even steps from `low` to `high`; what is beyond stands at
/// the end. A page lists them among the layers.
struct PagedValues {
    std::size_t chart = 0;
    std::string name;
    double low = 0, high = 1;
    bool diverging = false;  ///< blue and red, with the middle pale; else dark to light
    std::vector<std::uint8_t> codes;
};

/// The mesh that a map was made of, to be shown beside it.
struct PagedSource {
    std::vector<model::Vec3d> positions;
    std::vector<model::Face> faces;
    std::string values;               ///< name of the PagedValues whose scale `codes` has
    std::vector<std::uint8_t> codes;  ///< one a position, or none
};

struct PagedMap {
    std::string name;  ///< shown in the list of maps
    const model::MapSet* maps = nullptr;
    std::vector<PagedValues> values = {};
    std::optional<PagedSource> source = {};
    std::string facts = {};  ///< a line that is shown with the map
};

/// A recorded tool path; one whose name begins with that of a map is offered for that map alone.
struct PagedPath {
    std::string name;  ///< shown in the list of paths, with spaces for underscores
    std::string text;  ///< as formats/path has it
};

struct PageSettings {
    std::string title;
    bool z_is_up = false;
    std::optional<std::array<double, 2>> view = {};  ///< yaw and pitch in degrees, as render::View
    std::string look = {};                           ///< what the surface is coloured by at first
    bool framed = false;                             ///< inside of another page: one map, no list of maps
    bool cover = false;                              ///< the second map lies over the first one, which gives way to it
    std::vector<PagedPath> paths = {};
    std::vector<std::byte> still = {};  ///< JPEG, for browsers that cannot draw the surface; may be empty
};

/// False in a build without the runtime for pages (DGM_PAGE).
[[nodiscard]] bool can_make_pages();

/// The text of a page in which `maps` are turned and touched; without any, one that maps are dropped on. Same maps,
/// same bytes. `scratch` is a file that may be written.
/// @throws model::Error kUnsupported in a build without the runtime for pages; as packed_map()
[[nodiscard]] std::string page_file(const PageSettings& settings, std::span<const PagedMap> maps,
                                    const std::filesystem::path& scratch);

}  // namespace dgm::page
