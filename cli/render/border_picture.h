// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/border_picture.h
// Pictures of a chart's border: the seam table and a free domain's border samples (for layer_picture).
#pragma once
#include "model/map_set.h"
#include "model/vec.h"
#include "render/layer_picture.h"

namespace dgm::render {

/// Position in the chart's bounding box as red, green, blue; a flat side gives 128.
[[nodiscard]] model::Rgba8 position_colour(const model::Chart& chart, const model::Vec3d& position);
/// Unit vector as red, green, blue, -1..1 to 0..255.
[[nodiscard]] model::Rgba8 normal_colour(const model::Vec3d& normal);

/// @throws model::Error kBadLayerShape, kBadSeamTable
[[nodiscard]] LayerPicture seam_picture(const model::Chart& chart, const model::Layer& seams);
[[nodiscard]] LayerPicture border_picture(const model::Chart& chart, const model::Layer& layer);

}  // namespace dgm::render
