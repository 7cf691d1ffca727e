// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/layer_picture.h
// One picture for each layer of a chart: row i down, column j to the right (docs/design.md section 1).
#pragma once
#include <string>
#include <string_view>

#include "image/image.h"
#include "model/map_set.h"

namespace dgm::render {

struct LayerPicture {
    formats::Image image;
    std::string note;  ///< meaning of the colours: "0 .. 0.0132"
};

/// The picture of `layer` at the layer's own resolution:
///
/// geometry     x, y, z of the chart's bounding box as red, green, blue 0..255
/// normal       x, y, z from -1..1 as red, green, blue 0..255
/// texture      as it is stored
/// bump         diverging colours, white at 0, blue below the surface
/// collision    diagonals of the leaf boxes, sequential colours, one block of pixels a tile
/// cover        sequential colours
/// deformation  2 x 2 tiles: E, F / G, stiffness; F diverging, the others sequential
/// contact      2 tiles: area, mobility (black 0 to white 1)
/// reversed     the same as seams
/// seams        samples of one class in one colour, by where the class first meets the border; drawn as dots
/// diagonals    violet 0, yellow 1
/// mask         black 0, white 1
/// border_*     the mask, the strip's triangles and the border samples in (u, v); the samples in the colours of their
///              layer (border_faces: plain)
///
/// Tiles stand kTileGap pixels apart. In a free domain, samples that are off the surface are gray.
/// @throws model::Error kMissingLayer if the chart has no such layer, kBadLayerShape, kUnsupported for a name unknown
///         here, kTooLarge if the picture would be beyond formats::kMaxImageSide
[[nodiscard]] LayerPicture layer_picture(const model::Chart& chart, std::string_view layer);

inline constexpr std::uint32_t kTileGap = 2;
inline constexpr model::Rgba8 kOffSurface{222, 222, 220, 255};

}  // namespace dgm::render
