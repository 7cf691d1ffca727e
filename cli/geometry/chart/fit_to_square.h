// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/fit_to_square.h
// Stretches a free chart over the unit square, and divides its border by the grid's cells.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/cut/disk.h"

namespace dgm::bake {

/// Rule that chooses the bounding rectangle of a chart to be stretched over the square, by its sides in steps of m x n
/// samples.
enum class Box {
    kLeastArea,
    kLeastSquares,  ///< of the sides: an isometric chart is stretched least in it
};

/// Turns the chart and stretches its bounding rectangle over the unit square.
void fit_to_square(std::vector<Vec2d>& uv, std::span<const std::uint32_t> border, std::uint32_t m, std::uint32_t n,
                   Box box);

/// Splits a border edge at parameter t, and its mate at the same place; `uv` grows by the new vertices.
NewVertices split_border(Disk& disk, std::vector<Vec2d>& uv, std::uint32_t h, double t);

/// Divides border edges longer than one grid cell, on both sides of a cut at the same places. A border so long that
/// this would add more than four vertices a sample of the grid is divided into longer pieces, so that it adds no more.
/// @param rows, cols  cells of the grid
void divide_border(Disk& disk, std::vector<Vec2d>& uv, double rows, double cols);

}  // namespace dgm::bake
