// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/source_edges.h
// The edges of the source that are near each sample of a grid.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "geometry/fit/fit_state.h"

namespace dgm::bake {

/// Per class of the grid the nearest few edges that the source turns at by more than the grid's error explains.
/// Thread-safe once made.
class SourceEdges {
 public:
    /// Lays the edges over the grid; bounded work.
    /// @param fit      must outlive the object; the matches are up to date
    /// @param rms      of the fit
    /// @param spacing  of the grid's samples
    SourceEdges(FitState& fit, double rms, double spacing);

    [[nodiscard]] bool has_any(std::uint32_t c) const { return first_[c] < first_[c + 1]; }
    /// Points of a class's edges that are the nearest to `from`, and ends of them that are nearer than the spacing.
    [[nodiscard]] std::vector<Vec3d> places(std::uint32_t c, const Vec3d& from) const;

 private:
    using Pair = std::pair<std::uint32_t, std::uint32_t>;  // class, half edge

    [[nodiscard]] std::pair<Vec3d, Vec3d> ends(std::uint32_t half_edge) const;
    [[nodiscard]] Vec3d foot(std::uint32_t half_edge, const Vec3d& from) const;
    [[nodiscard]] std::vector<std::uint32_t> faces_over_vertices() const;
    [[nodiscard]] std::vector<Pair> lay_over_grid(double sine) const;
    void list_nearest(const std::vector<Pair>& pairs);

    FitState& fit_;
    double spacing_;
    std::vector<std::uint32_t> first_, edges_;  // of a class: edges_[first_[c]] .. edges_[first_[c + 1] - 1]
};

}  // namespace dgm::bake
