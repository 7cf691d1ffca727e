// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/chart_mesh.h
// One chart as every mesh format takes it: samples, the faces that name them, and what it is called.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "model/map_set.h"
#include "model/tri_mesh.h"
#include "model/vec.h"

namespace dgm::bake {
struct Reconstruction;
}

namespace dgm::exporter {

/// One chart as it is exported: samples, and the faces that name them.
struct ChartMesh {
    std::vector<model::Vec3d> positions;  ///< relative to the origin that chart_mesh() was given
    std::vector<model::Vec3d> normals;    ///< unit; empty if the chart has none
    std::vector<model::Vec2d> uvs;        ///< (u, v): row and column as shares of the grid
    std::vector<model::Face> faces;
};

/// The samples of `surface` less `origin`, and its faces, or `coarse` instead.
[[nodiscard]] ChartMesh chart_mesh(const bake::Reconstruction& surface, const model::Vec3d& origin,
                                   const std::vector<model::Face>* coarse);

/// The vertices below `count` that a face names, in their order.
[[nodiscard]] std::vector<std::uint32_t> named_vertices(const std::vector<model::Face>& faces, std::size_t count);

/// `faces` with each vertex replaced by its place in `used`, as named_vertices() gives it.
[[nodiscard]] std::vector<model::Face> renumbered(std::vector<model::Face> faces,
                                                  const std::vector<std::uint32_t>& used);

/// Whether the surface has a border that is no seam.
[[nodiscard]] bool is_open(const bake::Reconstruction& surface);

/// Where (u, v) lies in a picture of across x down texels, from its left and its top: corner samples on the middles of
/// corner texels.
[[nodiscard]] model::Vec2d place_in_picture(const model::Vec2d& uv, std::uint32_t across, std::uint32_t down);

/// The name of the source's file without its ending; "surface" where there is none.
[[nodiscard]] std::string asset_name(const model::MapSet& maps);

/// The name of each chart in a scene of many assets: the asset's, with "_chart<k>" behind it if there are several.
[[nodiscard]] std::vector<std::string> chart_names(const model::MapSet& maps);

}  // namespace dgm::exporter
