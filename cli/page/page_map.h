// SPDX-License-Identifier: GPL-3.0-or-later
// cli/page/page_map.h
// A map as a page carries it: what touching and seeing it needs, and no more.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "model/map_set.h"

namespace dgm::page {

/// Picture of a chart, as a file that browsers decode.
struct PagePicture {
    std::size_t chart = 0;
    const char* type = "";  ///< "image/jpeg"; "image/png" if it has transparent pixels or is smaller so
    std::vector<std::byte> bytes;
};

/// `maps` with positions of 16 bits and the layers that touching needs: seams, diagonals, the material and the tables
/// of free charts; stiffness and mobility where they are not 1 everywhere. Positions that have 16 bits already keep
/// theirs; others move by half a step at most, which is 1/131070 of the chart's largest extent.
/// @throws model::Error kMissingLayer, kBadLayerShape for a geometry that is not as SPEC.md has it
[[nodiscard]] model::MapSet touch_layers(const model::MapSet& maps);

/// The texture of each chart that has one.
[[nodiscard]] std::vector<PagePicture> page_pictures(const model::MapSet& maps);

/// The bytes of touch_layers(maps) as a .dgm whose positions went through code_grid(), and where they are:
/// "OFFSET,ROWS,COLS OFFSET,ROWS,COLS ...". `scratch` is written and left there.
/// @throws model::Error as touch_layers() and formats::write_dgm
struct PackedMap {
    std::vector<std::byte> bytes;
    std::string grids;
};
[[nodiscard]] PackedMap packed_map(const model::MapSet& maps, const std::filesystem::path& scratch);

}  // namespace dgm::page
