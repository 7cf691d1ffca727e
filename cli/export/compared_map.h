// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/compared_map.h
// What a page shows of a map beside its source: the source itself, and the error and the distortion as colours.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "model/tri_mesh.h"
#include "page/page_file.h"
#include "render/chart_colours.h"
#include "render/surface_values.h"

namespace dgm::exporter {

/// Vertices of the source at most; it is simplified to that (render::draw_mesh).
inline constexpr std::size_t kMostSourceVertices = 20'000;

/// Names of the values, as a page lists them.
inline constexpr char kDistanceName[] = "distance to the source", kAreaName[] = "area distortion, log2",
                      kAngleName[] = "angle distortion, log2";

/// What is known of a map and its source: values of each chart, distances of each vertex of the source.
struct Compared {
    const model::TriMesh& source;
    std::span<const double> distances;
    std::span<const render::SurfaceValues> values;
    render::Scales scales;
};

/// Puts source and values into `map`.
void add_comparison(const Compared& compared, page::PagedMap& map);

/// Measures `map` against `source`, and does the same. @throws model::Error as bake::reconstruct()
void compare_with(const model::TriMesh& source, page::PagedMap& map);

/// Puts bump heights into `map` where a chart has them that are not all 0: at each sample, the texel that is nearest.
void add_bump(page::PagedMap& map);

/// What a bake measured, from its report: "rms error 0.0123 (0.004 % of the diagonal), largest ..."; empty if the
/// report does not say.
[[nodiscard]] std::string measured_errors(const nlohmann::json& report);

}  // namespace dgm::exporter
