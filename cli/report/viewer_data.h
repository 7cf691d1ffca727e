// SPDX-License-Identifier: GPL-3.0-or-later
// cli/report/viewer_data.h
// The geometry that a page's viewer draws, small enough for a page.
//
// Positions are u16 triples: low + step * stored, step the same on all axes. Normals are signed bytes (x, y, z) / 127.
// Arrays are little-endian, in base64.
#pragma once
#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "geometry/metrics/reconstruction.h"
#include "model/map_set.h"
#include "model/tri_mesh.h"
#include "render/camera.h"
#include "report/chart_colours.h"
#include "report/surface_values.h"

namespace dgm::report {

/// Vertices of each of the two surfaces at most; with their faces both take about 1.2 MB of a page.
inline constexpr std::size_t kMostVertices = 20'000;

struct ViewedCharts {
    std::span<const model::Chart> charts;
    std::span<const bake::Reconstruction> surfaces;  ///< of each chart
    std::span<const SurfaceValues> values;           ///< of each chart
};

struct ViewedSource {
    const model::TriMesh& mesh;
    std::span<const double> distances;  ///< source_distances()
};

/// Keys: view (yaw, pitch, in degrees), low, step, stride, charts (how many of them are shown: the first ones that
/// fit), diagonal, scales, tables (256 colours each), source and map. Both of these: position, normal, index (u16 or,
/// if `wide`, u32), `simplified` for the source. A byte a vertex (places in the
/// colour tables): distance; the map also: area, angle (places in
/// the colour tables), and index pairs: grid, seams, borders. A distance is the largest of the samples that its vertex
/// stands for. No key `map` if not even one chart fits.
[[nodiscard]] nlohmann::json viewer_data(const ViewedSource& source, const ViewedCharts& map, const Scales& scales,
                                         double diagonal, const render::View& view,
                                         std::size_t most_vertices = kMostVertices);

}  // namespace dgm::report
