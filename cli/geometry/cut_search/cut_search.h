// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/cut_search/cut_search.h
// Searches the cut and the rotation of the border that give a component the least error.
#pragma once
#include <vector>

#include "geometry/chart/sampled_chart.h"
#include "geometry/cut/cut_graph.h"
#include "geometry/parameterize/square_border.h"
#include "model/progress.h"

namespace dgm::bake {

struct CutSearchOptions {
    std::uint32_t m = 257, n = 257;    ///< the grid the cut is for
    bool measured = false;             ///< try every cut on the component itself and measure it: slow, and sure
    bool reweighted = false;           ///< measured trials are reweighted maps, not stretch
    std::size_t coarse_faces = 5000;   ///< unless `measured`: a mesh half as large again is searched simplified to this
    std::uint32_t largest_side = 129;  ///< of the grid that trials are made on
    std::uint64_t samples = 8000;      ///< error samples per measured trial, beside the vertices
    int max_extremities = 40;
    int patience = 8;  ///< extremities tried in a row without a gain of 1 %
    std::size_t rotations = 4;
    std::size_t drops = 12;  ///< branches tried without, at most
    std::size_t stars = 0;   ///< octahedra tried on a closed component without handles (star_cut.h), for odd m and n
    bool only_stars = false;
    /// Where not 0, the cuts of a ring (ring_cut.h) are tried and nothing else: so many paths from loop to loop, with
    /// the loops on opposite sides of the grid.
    std::size_t rings = 0;
    /// The search of a component with handles starts where their loops meet in the best place of four, the second best
    /// or the third.
    CutStart start = CutStart::kLong;
    /// Seams are led through hidden places (hidden_cut.h) if the predicted error grows by at most this factor. 0: they
    /// are not. Nor are stars, nor where trials are measured.
    double given_to_hide = 1.01;
    /// If no cut of the simplified mesh can be mapped, fail instead of searching the full mesh: for callers who have
    /// another chart already.
    bool only_simplified = false;
};

struct CutSearchResult {
    Disk disk;                   ///< opened along the best cut, border not yet laid
    std::uint32_t rotation = 0;  ///< on the m x n grid
    BorderShares shares = BorderShares::kByLength;
    double rms = 0;         ///< of the best trial, as predicted or measured, normalised units
    double cut_length = 0;  ///< normalised units
    int trials = 0, extremities = 0;
};

/// Augments the cut as [Gu, Gortler, Hoppe 2002]: map, join the most shrunk point to the cut, repeat while the error of
/// the resampled surface falls; then branches are dropped where that lowers it, and rotations are tried.
///
/// The error is predicted (trial_map.h), and a large component is searched in simplified form and the cut carried back
/// (cut_transfer.h); where that fails, and if `measured` asks for it, every trial is baked on the component itself. In
/// the end paths that edges make jagged are pulled straight across faces (straight_cut.h), unless the error predicted
/// grows by more than a quarter of the share that the cut gets shorter, or where trials are measured; the disk has
/// vertices then that the component has not.
/// @throws model::Error kMapInvalid or kGridTooSmall if no cut gave a valid map; kMethodUnsuited if stars alone are
///     asked of a surface or a grid that has none, or rings of a surface that is none
[[nodiscard]] CutSearchResult search_cut(const TriMesh& component, const CutSearchOptions& options,
                                         const model::Progress& progress);

/// Searches again from the other starts (CutStart), beside each other: the cuts found whose predicted error is at most
/// `most_rms`. Starts without a valid map are left out.
/// @param options  neither measured, nor for stars or rings alone; the start is not heeded
/// @throws model::Error kInterrupted, or if memory is short
[[nodiscard]] std::vector<CutSearchResult> search_other_cuts(const TriMesh& component, const CutSearchOptions& options,
                                                             double most_rms, const model::Progress& progress);

}  // namespace dgm::bake
