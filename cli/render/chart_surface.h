// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/chart_surface.h
// Charts as one textured mesh, to draw and to export.
#pragma once
#include <span>
#include <vector>

#include "image/image.h"
#include "model/map_set.h"
#include "model/tri_mesh.h"
#include "render/renderer.h"

namespace dgm::render {

struct ChartSurface {
    /// All charts' vertices one after another, seam copies apart. face_materials is the number of the chart among
    /// those given; material k is named "chart<k>". corner_normals are there if every chart has the layer `normal`.
    /// corner_uvs put sample (i, j) on the middle of its texel of the chart's texture (of the grid, without one): with
    /// t x s texels, uv = ((v (s - 1) + 1/2) / s, 1 - (u (t - 1) + 1/2) / t), v up as in OBJ, row 0 at the top.
    model::TriMesh mesh;
    std::vector<formats::Image> textures;  ///< one a chart; an empty image where the chart has no texture
    double seam_gap = 0;                   ///< largest of the charts
    struct Edge {
        std::uint32_t a, b;
    };
    std::vector<Edge> grid;     ///< of every grid line or every few of them, about 32 a side
    std::vector<Edge> seams;    ///< border edges that meet another border edge
    std::vector<Edge> borders;  ///< border edges that do not
};

/// The layer `texture` as a picture, empty without one. @throws model::Error kBadLayerShape, kTooLarge
[[nodiscard]] formats::Image texture_picture(const model::Chart& chart);

/// @throws model::Error as bake::reconstruct; kBadLayerShape for a texture that is not u8 [mt][nt][4]
[[nodiscard]] ChartSurface chart_surface(std::span<const model::Chart> charts);

/// Edges as segments for the renderer.
void add_segments(Surface& surface, std::span<const ChartSurface::Edge> edges, model::Rgba8 colour, double radius);

}  // namespace dgm::render
