// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/polygon.h
// Splitting of a polygon in space into triangles.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "model/vec.h"

namespace dgm::formats {

/// Corners of a triangle as indices into the polygon.
using CornerTriple = std::array<std::uint32_t, 3>;

/// Point tests that splitting the polygons of one file may take: a number for each corner, whichever polygon needs
/// them, so that time grows with the file and not with the square of its polygons.
class PolygonBudget {
 public:
    [[nodiscard]] std::uint64_t left() const { return left_; }
    void earn(std::size_t corners) { left_ += kPerCorner * corners; }
    void spend(std::uint64_t tests) { left_ -= std::min(left_, tests); }

 private:
    /// Lines, combs, spirals, stars and slits of 200,000 corners take up to 103.
    static constexpr std::uint64_t kPerCorner = 512;
    std::uint64_t left_ = std::uint64_t{1} << 25;
};

/// Appends size - 2 triangles of the polygon's winding to `out`.
///
/// Ear clipping [Meisters 1975] in the coordinate plane nearest to the polygon's own (Newell normal), shortest diagonal
/// first. A quad that is convex or has no plane is split along corners 0 and 2. Where no ear is left (self-crossing or
/// flat polygons) the rest becomes a fan. Takes O(n log n) but for polygons that are made to take longer, such as those
/// that cross themselves everywhere: `budget` ends those.
/// @return false if a fan stood in for ears: also for polygons with a point that is not finite, and when the budget was
///         spent
/// @param corners  at least 3 points
[[nodiscard]] bool triangulate_polygon(std::span<const model::Vec3d> corners, std::vector<CornerTriple>& out,
                                       PolygonBudget& budget);

}  // namespace dgm::formats
