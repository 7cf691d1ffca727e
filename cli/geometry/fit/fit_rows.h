// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/fit_rows.h
// Rows of the normal equations in a round of the fit.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "geometry/fit/border_rails.h"
#include "geometry/fit/matches.h"
#include "geometry/fit/normal_equations.h"

namespace dgm::bake {

/// One row a match, from the source's points and back from the grid's, and those of the border.
class FitRows {
 public:
    /// All must outlive the object.
    /// @param points_per_sample  of the source, area-uniform: weight of a row of the border
    FitRows(const LinkedSurface& source, const WeldedGrid& grid, const Matches& matches, const BorderRails& rails,
            double points_per_sample)
        : source_(source), grid_(grid), matches_(matches), rails_(rails), points_per_sample_(points_per_sample) {}

    /// @param worst_only  pull hardest where the error is near the largest, and not much less where it was a round ago:
    /// otherwise the next round loses the gain of this one to points on the other side [Lawson 1961]
    /// @param near  per face of the grid: rows of these alone; all if empty
    /// @param with_border  the rows of the border too, all of them
    void assemble(NormalEquations& equations, bool worst_only, std::span<const char> near = {},
                  bool with_border = false);

    /// The grid's edges have been numbered anew.
    void forget_edges() { pulls_[1].clear(); }

 private:
    struct Round;

    const LinkedSurface& source_;
    const WeldedGrid& grid_;
    const Matches& matches_;
    const BorderRails& rails_;
    double points_per_sample_;
    std::array<std::vector<double>, 4> pulls_;  // beyond 1, of points, edges, middles and classes
};

}  // namespace dgm::bake
