// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/cell_rectangle.h
// The square as a rectangle in which the cells of the grid are squares.
#pragma once
#include <vector>

#include "geometry/parameterize/parameterizer.h"

namespace dgm::bake {

/// Maps between the unit square and the rectangle of area 1 with sides as `disk.aspect`, where one unit of length is as
/// many cells of the grid in either direction: there, stretch is that of the samples' steps.
class CellRectangle {
 public:
    /// @param disk  a fixed border on the unit square; must outlive the object
    explicit CellRectangle(const DiskView& disk);
    CellRectangle(const CellRectangle&) = delete;
    CellRectangle& operator=(const CellRectangle&) = delete;

    /// The same disk with its border on the rectangle.
    [[nodiscard]] const DiskView& view() const { return view_; }
    [[nodiscard]] std::vector<Vec2d> from_square(std::vector<Vec2d> uv) const;
    /// The border goes to `disk.border_uv` to the bit.
    [[nodiscard]] std::vector<Vec2d> to_square(std::vector<Vec2d> uv) const;

 private:
    const DiskView& disk_;
    double width_;
    std::vector<Vec2d> border_;
    DiskView view_;
};

}  // namespace dgm::bake
