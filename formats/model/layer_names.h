// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/layer_names.h
// Names the layers and tables of a chart as files store them (formats/SPEC.md). Makers, readers and options use these
// constants, so that a misspelt name does not compile.
#pragma once

namespace dgm::model::layers {

inline constexpr char kGeometry[] = "geometry", kNormal[] = "normal", kTexture[] = "texture", kBump[] = "bump",
                      kCollision[] = "collision", kCover[] = "cover", kDeformation[] = "deformation",
                      kContact[] = "contact", kMaterial[] = "material";
/// Attribute of geometry: length of a unit, f64[1].
inline constexpr char kMetresPerUnit[] = "metres_per_unit";
/// Tables that readers of the geometry need.
inline constexpr char kSeams[] = "seams", kReversed[] = "reversed", kDiagonals[] = "diagonals", kMask[] = "mask",
                      kBorderUv[] = "border_uv", kBorderFaces[] = "border_faces", kBorderGeometry[] = "border_geometry",
                      kBorderNormal[] = "border_normal";

}  // namespace dgm::model::layers
