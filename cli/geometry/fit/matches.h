// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/fit/matches.h
// Points of the source and of the grid, each with its closest point on the other surface.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "geometry/fit/fit.h"
#include "geometry/fit/welded_grid.h"
#include "geometry/spatial/closest_point.h"

namespace dgm::bake {

struct Match {
    Vec3d position;
    SurfaceHit hit;  ///< on the other surface
    double weight = 1;
};

/// Squared distances of a piece of a list of matches (pieces.h).
struct PieceOfMatches {
    double farthest = 0, sum = 0;
};

/// The matches of a chart being fitted. A match starts where the map puts it and walks on from its last answer, so
/// looking up all of them again after a small move costs a few triangles each. Where the source has more faces than the
/// grid, walks over it would stop at the first bump: there the grid's points are looked up by index.
/// `update` runs in parallel and gives the same bits for any number of threads.
class Matches {
 public:
    /// About `count` area-uniform points of the source and its vertices, which weigh a quarter; all classes of the
    /// grid and the middles of its faces. The references must outlive the object.
    Matches(const SampledChart& chart, const LinkedSurface& source, const WeldedGrid& grid, std::size_t count,
            const Hold& hold = kLoose);

    /// Looks everything up for the grid's present shape. `with_edges`: the middles of the edges too, where a chord
    /// across a fold is farthest from it; they have no weight, but count for `largest`.
    /// @param near  per face of the grid: look up only the points matched there, since no other face has moved; all if
    /// empty
    void update(bool with_edges, std::span<const char> near = {});
    /// After `update` with edges: the farthest matches once more, against all faces of the other surface. Walks stop in
    /// local minima, and their farthest points may lie on another fold; `largest` is then the distance of a place that
    /// nothing can bring closer. Where only a wall that looks the other way is closer, the match stays with its own.
    /// @param source_index  of the source
    void settle_farthest(const ClosestPointIndex& source_index);
    /// The disk's index if the source has more faces than the grid; else null.
    [[nodiscard]] const ClosestPointIndex* source_index() const { return source_index_; }
    /// The middle of one face again, after a corner of it has moved.
    void update_middle(std::size_t face);

    /// Faces that walks have looked at, those of all updates and those that were counted: the same for any number of
    /// threads.
    [[nodiscard]] std::uint64_t looked() const { return looked_; }
    void count_looks(std::uint64_t faces) { looked_ += faces; }
    /// Most that one repair may look at. A walk over a crowd of tiny faces looks at thousands.
    static constexpr std::uint64_t kMostLooksOfRepair = 300'000'000;

    /// Faces of the grid with a match of the last update farther away than that; ascending.
    [[nodiscard]] std::vector<std::uint32_t> faces_beyond(double distance) const;

    std::vector<Match> points;                              ///< of the source
    std::size_t area_points = 0;                            ///< first so many are area-uniform, the others its vertices
    std::vector<Match> classes, middles, edges;             ///< of the grid
    std::vector<std::pair<std::uint32_t, int>> edge_place;  ///< a face of the edge and its number there
    double rms = 0, largest = 0;                            ///< symmetric, of the last update

 private:
    void spread(const SampledChart& chart, std::size_t count);
    void start(const SampledChart& chart);
    void update_edges(std::span<const char> near);
    void look_again_far_off(std::span<const char> near);
    void weigh_and_measure();
    [[nodiscard]] double farthest_squared() const;
    /// Matches of a list whose squared distances are summed up.
    [[nodiscard]] std::size_t counted(std::size_t list) const { return list == 0 ? area_points : 0; }

    [[nodiscard]] SurfaceHit on_source(const Vec3d& p, const Vec3d& normal, std::uint32_t start,
                                       std::uint64_t* looked = nullptr) const;
    void update_middle(std::size_t face, std::uint64_t* looked);

    const LinkedSurface& source_;
    const WeldedGrid& grid_;
    const ClosestPointIndex* source_index_ = nullptr;  // only for a source denser than the grid
    Hold hold_;
    double slack_ = 0;
    std::uint64_t looked_ = 0;
    std::array<std::vector<PieceOfMatches>, 4> pieces_;  // of points, classes, middles and edges
};

}  // namespace dgm::bake
