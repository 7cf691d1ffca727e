// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/square_border.h
// The border of a disk laid on the border of the square, so that both sides of every cut sample the same points.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "geometry/cut/disk.h"
#include "geometry/mesh/surface_sample.h"

namespace dgm::bake {

/// One of the 2(m-1) + 2(n-1) samples of the square's border, counter-clockwise in (u, v) from (0, 0).
struct BorderSample {
    std::uint32_t index;  ///< flat sample index i*n+j
    SurfaceSample at;     ///< on this side of the cut
    std::uint32_t
        same_as;  ///< position in the border cycle of the first sample of its class; itself if it is the first
    bool reversed = false;  ///< the surface here winds against that at the first sample of its class
};

struct SquareBorder {
    std::vector<std::uint32_t> vertices;  ///< border cycle of the (split) disk
    std::vector<Vec2d> uv;                ///< of those vertices, counter-clockwise on the unit square's border
    std::vector<BorderSample> samples;
    double smallest_interval = 0;  ///< shortest path length per interval, normalised units
};

/// Grid corner k (0..3) counted in border samples.
struct BorderGrid {
    std::uint32_t m, n;
    [[nodiscard]] std::uint32_t count() const { return 2 * (m - 1) + 2 * (n - 1); }
    [[nodiscard]] std::uint32_t corner(int k) const {
        return k == 0 ? 0 : k == 1 ? m - 1 : k == 2 ? m + n - 2 : 2 * m + n - 3;
    }
    /// Flat index of border sample t.
    [[nodiscard]] std::uint32_t sample(std::uint32_t t) const;
    /// (u, v) of real-valued border position t in [0, count()); exact on the sides.
    [[nodiscard]] Vec2d uv(double t) const;
};

/// How the intervals of the square's border are shared out.
enum class BorderShares {
    kByLength,   ///< to each path by its length
    kEqualArms,  ///< the cut is a star of four arms: its middle on the four corners, each side folds at its middle
    kLoopsOnM,   ///< the cut is a path between two loops: they on the sides of m samples, it on both sides of n
    kLoopsOnN,   ///< the same, the loops on the sides of n samples
};

/// True where the loops of a ring lie on opposite sides of the square.
[[nodiscard]] constexpr bool faces_loops(BorderShares shares) {
    return shares == BorderShares::kLoopsOnM || shares == BorderShares::kLoopsOnN;
}

/// Lays the disk's border on the square (docs/methods.md section 2): path p gets a whole number of sample intervals,
/// the same for both mates, nearest its share of the length; inside a path vertices follow arc length; the square's
/// corners fall on samples, and an edge (with its mate) is split where one falls inside it. Then every interior edge
/// that joins two points of the border is split, so that no triangle can collapse onto a side and no part of the
/// surface is locked up behind a straight edge.
///
/// Changes `disk` by those splits. `rotation` moves the first path's start to border sample `rotation`; only shares by
/// length heed it.
/// @throws model::Error kGridTooSmall if the paths need more intervals than the grid has; kMethodUnsuited if equal arms
///     are asked of another cut than a star of four, or of even m or n, or loops are to face each other that no single
///     path joins
[[nodiscard]] SquareBorder lay_square_border(Disk& disk, std::uint32_t m, std::uint32_t n, std::uint32_t rotation,
                                             BorderShares shares = BorderShares::kByLength);

/// The paths of the disk's border for a grid that has `total` border intervals: corners of the real border are nodes,
/// but only the sharper ones, or none, where all need more intervals than that. A scan's holes are jagged, and may have
/// more corners than the grid has samples.
[[nodiscard]] std::vector<BorderPath> border_paths(const Disk& disk, std::uint32_t total);

/// Whole numbers of intervals for each path (mates equal), all together `total`; by largest remainder, at least
/// `least(path)`. Exposed for its test. @throws kGridTooSmall
[[nodiscard]] std::vector<std::uint32_t> allocate_intervals(const std::vector<BorderPath>& paths, std::uint32_t total);

/// Rotations worth trying: no leaf of the cut on a corner of the square, corners of the real border on it where they
/// fit.
[[nodiscard]] std::vector<std::uint32_t> candidate_rotations(const Disk& disk, std::uint32_t m, std::uint32_t n,
                                                             std::size_t how_many);

/// The rotation nearest to `wanted` that leaves no leaf of the cut on a corner of the square; `wanted` if there is
/// none.
[[nodiscard]] std::uint32_t nearest_rotation(const Disk& disk, std::uint32_t m, std::uint32_t n, std::uint32_t wanted);

}  // namespace dgm::bake
