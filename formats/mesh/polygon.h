// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/polygon.h
// Splitting of a polygon in space into triangles.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "model/error.h"
#include "model/vec.h"

namespace dgm::formats {

/// Corners of a triangle as indices into the polygon.
using CornerTriple = std::array<std::uint32_t, 3>;

/// Work that splitting the polygons of one file may take and cause.
///
/// Point tests: a number for each corner, whichever polygon needs them, so that time grows with the file and not with
/// the square of its polygons. Crossings: the squares of the corners that have no ears and become fans. Faces of such a
/// fan lie over one another, and what follows looks at each for each: one of 500 corners takes half a minute of a bake,
/// one of 10,000 had not ended after ten minutes.
class PolygonBudget {
 public:
    [[nodiscard]] std::uint64_t left() const { return left_; }
    void earn(std::size_t corners) { left_ += kPerCorner * corners; }
    void spend(std::uint64_t tests) { left_ -= std::min(left_, tests); }

    /// For a polygon whose last `corners` corners cross one another.
    void cross(std::size_t corners) {
        if (corners >= kFewCorners) crossings_ += std::uint64_t{corners} * corners;
    }
    /// Whether the polygons so far cross themselves beyond what can be baked.
    [[nodiscard]] bool is_crossed() const { return crossings_ > kMostCrossings; }

 private:
    /// Lines, combs, spirals, stars and slits of 200,000 corners take up to 103.
    static constexpr std::uint64_t kPerCorner = 512;
    static constexpr std::size_t kFewCorners = 16;                           ///< ordinary bow ties are not counted
    static constexpr std::uint64_t kMostCrossings = std::uint64_t{1} << 20;  ///< one fan of 1,024, or 256 of 64
    std::uint64_t left_ = std::uint64_t{1} << 25;
    std::uint64_t crossings_ = 0;
};

/// The error kPolygonCrosses for budget.is_crossed(). @param place  of the polygon that was one too many
[[nodiscard]] model::Error crossed_polygons(const std::string& place);

/// Appends size - 2 triangles of the polygon's winding to `out`.
///
/// Ear clipping [Meisters 1975] in the coordinate plane nearest to the polygon's own (Newell normal), shortest diagonal
/// first. A quad that is convex or has no plane is split along corners 0 and 2. Where no ear is left (self-crossing or
/// flat polygons) the rest becomes a fan. Takes O(n log n) but for polygons that are made to take longer, such as those
/// that cross themselves everywhere: `budget` ends those, and knows whether there were too many.
/// @return false if a fan stood in for ears: also for polygons with a point that is not finite, and when the budget was
///         spent
/// @param corners  at least 3 points
[[nodiscard]] bool triangulate_polygon(std::span<const model::Vec3d> corners, std::vector<CornerTriple>& out,
                                       PolygonBudget& budget);

}  // namespace dgm::formats
