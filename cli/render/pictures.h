// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/pictures.h
// Whole pictures: a bake beside its source, and a sheet of a chart's layers.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "image/image.h"
#include "model/map_set.h"
#include "model/tri_mesh.h"
#include "render/camera.h"
#include "render/chart_surface.h"

namespace dgm::render {

struct PictureOptions {
    std::uint32_t width = 1280, height = 960;
    std::optional<View> view;  ///< default: choose_view() of the first surface
    UpAxis up = UpAxis::kY;    ///< for choose_view()
    std::uint32_t samples_per_pixel = 16;
};

/// The surface of the charts, lit, with their textures. @throws model::Error as render_mesh
[[nodiscard]] formats::Image surface_picture(const ChartSurface& charts, const PictureOptions& options);

/// Four panels with captions, one camera: the source; the reconstruction; the reconstruction with its grid and its
/// seam (red) and border (blue); how far each reconstruction vertex is from the source, in % of the source's
/// bounding-box diagonal, with a legend that ends at the 99th percentile. In a row if the picture is more than twice
/// as wide as high, else two by two.
/// @throws model::Error kTooLarge if the picture is under 320 x 160 pixels or too large; kNoFaces for an empty source
[[nodiscard]] formats::Image comparison_picture(const model::TriMesh& source,
                                                std::vector<formats::Image> source_textures, const ChartSurface& charts,
                                                const PictureOptions& options);

/// All layers of a chart that have a picture, each with name, shape, type and range, after a shaded view of it.
/// `title` is the sheet's first line. Four columns.
/// @throws model::Error as layer_picture and render_mesh
[[nodiscard]] formats::Image contact_sheet(const model::Chart& chart, const std::string& title,
                                           const PictureOptions& options);

}  // namespace dgm::render
