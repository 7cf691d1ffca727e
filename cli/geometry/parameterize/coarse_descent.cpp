// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/coarse_descent.cpp
#include "geometry/parameterize/coarse_descent.h"

#include <cstddef>

#include "geometry/parameterize/multilevel_map.h"

namespace dgm::bake {
namespace {
constexpr std::size_t kCoarseFaces = 1200;  // of the level, beside two for each border vertex
constexpr std::size_t kWorthCoarse = 3000;  // the same: a mesh of less than twice that is as quick without one
}  // namespace

std::optional<std::vector<Vec2d>> map_coarsely(const DiskView& disk, const std::vector<Vec2d>& start,
                                               const CoarseDescent& descend, const model::Progress& progress) {
    if (disk.faces.size() <= 2 * (kWorthCoarse + 2 * disk.border.size())) return std::nullopt;
    std::vector<Vec2d> outline;
    for (const std::uint32_t v : disk.border) outline.push_back(start[v]);
    MultilevelOptions options;
    options.coarsest_faces = kCoarseFaces;
    options.coarsest_sweeps = 0;
    options.sweeps = 3;
    options.power = 1;
    options.map_coarsest = descend;
    try {
        return multilevel_stretch_map({disk.positions, disk.faces, disk.border, outline}, options, progress);
    } catch (const model::Error& e) {
        if (e.code().number != model::codes::kMapInvalid.number) throw;
        return std::nullopt;
    }
}

}  // namespace dgm::bake
