// SPDX-License-Identifier: GPL-3.0-or-later
// cli/render/chart_colours.h
// Values of a chart as pictures of its grid, with the scales that all pictures of an asset share.
#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "image/image.h"
#include "model/map_set.h"
#include "render/surface_values.h"

namespace dgm::render {

/// Ends of the colour scales: -end..end for distance and area, 0..end for angle.
struct Scales {
    double distance = 0;         ///< source units; the 99th percentile of the sizes
    double worst = 0;            ///< the largest size
    double area = 1, angle = 1;  ///< log2, at least 1: below a factor of 2 there is little to see
};
[[nodiscard]] Scales scales_of(std::span<const SurfaceValues> charts, std::span<const double> source_distances);

enum class Quantity { kDistance, kArea, kAngle };

/// Where a value stands in its colour table, 0..1; NaN stays.
[[nodiscard]] double table_place(Quantity quantity, double value, const Scales& scales);
/// Diverging for distance (blue inside) and area (blue dense), sequential for angle; `place` as table_place.
[[nodiscard]] model::Rgba8 quantity_colour(Quantity quantity, double place);

/// A pixel a sample, row i down; samples that no face uses are gray.
[[nodiscard]] formats::Image grid_picture(const model::Chart& chart, const SurfaceValues& values, Quantity quantity,
                                          const Scales& scales);

}  // namespace dgm::render
