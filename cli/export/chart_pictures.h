// SPDX-License-Identifier: GPL-3.0-or-later
// cli/export/chart_pictures.h
// The pictures of a chart's material: colour and normal map, in the sizes that a client wants.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "export/chart_mesh.h"
#include "image/image.h"

namespace dgm::exporter {

struct ChartPictures {
    formats::Image colour;  ///< empty if the chart has no texture
    std::optional<formats::Image> normal_map;
    std::vector<model::Vec3d> tangents;  ///< of the mesh's vertices; empty without a normal map
};

/// The layer `texture` and the tangent-space normal map of `mesh` (tangent_space.h). With `power_of_two` both sides of
/// each are those of nearest_power_of_two(). @throws as render::texture_picture and tangent_normal_map
[[nodiscard]] ChartPictures chart_pictures(const model::Chart& chart, const bake::Reconstruction& surface,
                                           const ChartMesh& mesh, bool power_of_two);

/// Brings both pictures to one size, the larger of each side, for clients with one set of texture coordinates.
void share_size(ChartPictures& pictures);

/// The power of two whose ratio to `side` is nearest to 1; of two that are as near the larger. At least 1, at most
/// formats::kMaxImageSide.
[[nodiscard]] std::uint32_t nearest_power_of_two(std::uint32_t side);

enum class Texels { kColour, kNormals };

/// The picture with width x height texels, by a tent filter that is as wide as a texel of the coarser of the two. The
/// middles of corner texels stay where they are, so texture coordinates by place_in_picture() of the new size show the
/// same. kNormals: results are made unit again. The same size gives the same picture.
[[nodiscard]] formats::Image resized(const formats::Image& picture, std::uint32_t width, std::uint32_t height,
                                     Texels texels);

}  // namespace dgm::exporter
