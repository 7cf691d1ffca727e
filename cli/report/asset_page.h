// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/asset_page.h
// One asset on one page that needs no other file.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace dgm::report {

struct AssetPage {
    nlohmann::json asset;          ///< its entry in the batch report (docs/schemas/report.schema.json)
    std::filesystem::path source;  ///< the mesh
    std::filesystem::path map;     ///< the .dgm or .exr that was made of it
    std::string command;           ///< to bake it again
    std::string key;               ///< what the page was made from; see page_key
    std::string index_link;        ///< relative, from the page to the index
    std::vector<std::filesystem::path> asset_roots = {};  ///< as BakeOptions has them
};

/// Raised when pages look or say something else for the same input.
inline constexpr int kPageVersion = 2;

/// The page's text; `scratch` is a file that may be written. The same bytes for the same input, but for what stands
/// between the comments kRunStart and kRunEnd.
/// Its head holds the key and two thumbnails, of the reconstruction and of the error, for the index.
/// Reads a stranger's mesh: run it in a worker process.
/// @throws model::Error as the readers, the renderer and reconstruct()
[[nodiscard]] std::string asset_page(const AssetPage& page, const std::filesystem::path& scratch);

inline constexpr const char* kRunStart = "<!-- of this run: times -->";
inline constexpr const char* kRunEnd = "<!-- end of this run -->";

}  // namespace dgm::report
