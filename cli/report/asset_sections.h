// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/asset_sections.h
// Writes the sections of an asset's page.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "baking/bake_report.h"
#include "geometry/metrics/reconstruction.h"
#include "model/map_set.h"
#include "model/tri_mesh.h"
#include "render/camera.h"
#include "render/chart_colours.h"
#include "render/surface_values.h"
#include "report/asset_page.h"

namespace dgm::report {

using render::Quantity, render::Scales, render::SurfaceValues;

/// A baked file, read back, with the values that its page shows.
struct BakedAsset {
    const AssetPage& page;
    bake::BakeReport report;
    model::MapSet maps;
    std::vector<bake::Reconstruction> surfaces;  ///< of each chart
    std::vector<SurfaceValues> values;           ///< of each chart
    Scales scales;
    [[nodiscard]] double diagonal() const { return report.error.diagonal; }
};

/// Source and map beside each other, the map to be touched: a page of cli/page in a frame. `distances` as
/// render::source_distances(). A line that says why instead where there is no such page.
/// @throws model::Error as page::page_file()
[[nodiscard]] std::string viewer_section(const BakedAsset& baked, const model::TriMesh& source,
                                         std::span<const double> distances, const render::View& view,
                                         const std::filesystem::path& scratch);
/// Error and distortion as pictures of the grid, and pictures of all layers; both of the first charts alone.
[[nodiscard]] std::string picture_sections(const BakedAsset& baked);
/// Measures, charts, the search for a grid and a method, repairs, and the command that bakes the asset again.
[[nodiscard]] std::string table_sections(const BakedAsset& baked);
/// Times of this run, between the comments kRunStart and kRunEnd.
[[nodiscard]] std::string times_section(const BakedAsset& baked);

}  // namespace dgm::report
