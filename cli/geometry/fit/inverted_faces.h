// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/inverted_faces.h
// Finds the faces of a grid that are inverted against the source, again and again while the grid moves.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/fit/matches.h"
#include "geometry/mesh/triangle.h"
#include "geometry/metrics/turned_faces.h"

namespace dgm::bake {

/// Stricter limits of the measure while the grid moves: its positions are still to be rounded, and a face that passes
/// narrowly before may fail after.
inline constexpr double kSafeTie = 0.5 * kTurnedTie, kSafeCosine = 0.01;

/// True of a thin face (height over longest edge) with so small a height, in normalised units, that rounding to 32 bits
/// may choose the side it looks to.
[[nodiscard]] inline bool is_flat(const std::array<Vec3d, 3>& q) {
    constexpr double kFlatHeight = 2e-7, kThin = 0.01;
    const double squared = longest_edge_squared(q), longest = std::sqrt(squared), doubled = 2 * face_area(q);
    return doubled < std::min(kFlatHeight * longest, kThin * squared);
}

/// Remembers its measurements: only faces that have moved since are measured again.
class InvertedFaces {
 public:
    /// All must outlive the object; `grid` may move and be linked anew in between.
    /// @param source  of `disk`
    InvertedFaces(const LinkedSurface& source, const LinkedSurface& grid, const SharedDisk& disk)
        : source_(source), grid_(grid), disk_(disk) {}

    /// Index of the source.
    [[nodiscard]] const ClosestPointIndex& source_index() const { return disk_.index(); }

    /// Inverted by the measure (metrics/turned_faces.h), of the faces marked in `among` or of all; ascending.
    /// @param nearly  those too that may be when they are rounded
    [[nodiscard]] std::vector<std::uint32_t> faces(std::span<const char> among = {}, bool nearly = false);

    /// The same of those whose cosine to the source below their middles is not above `upright`: cheap, and all there
    /// are but where a middle's match is on another sheet.
    [[nodiscard]] std::vector<std::uint32_t> doubtful_faces(const Matches& matches, double upright);

 private:
    struct Judged {
        std::array<Vec3d, 3> corners;
        bool nearly, inverted;
    };

    const LinkedSurface& source_;
    const LinkedSurface& grid_;
    const SharedDisk& disk_;
    std::vector<Judged> judged_;  // per face of the grid, when it was last looked at
};

}  // namespace dgm::bake
