// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/cut_search.h
// Which cut and which rotation of the border serve a component best, by measured error.
#pragma once
#include "geometry/chart/sampled_chart.h"
#include "geometry/cut/cut_graph.h"
#include "model/progress.h"

namespace dgm::bake {

struct CutSearchOptions {
    std::uint32_t m = 257, n = 257;
    std::uint64_t samples = 8000;   ///< error samples per trial, beside the vertices
    int max_extremities = 40;
    int patience = 4;               ///< extremities tried in a row without a gain of 1 %
    std::size_t rotations = 4;
    std::size_t drops = 12;         ///< branches tried without, at most
};

struct CutSearchResult {
    Disk disk;                 ///< opened along the best cut, border not yet laid
    std::uint32_t rotation = 0;
    double rms = 0;            ///< of the best trial, normalised units
    double cut_length = 0;     ///< normalised units
    int trials = 0, extremities = 0;
};

/// Augments the cut as [Gu, Gortler, Hoppe 2002]: map, join the most shrunk point to the cut, repeat while the measured
/// error of the resampled surface falls; then branches are dropped where that lowers it, and rotations are tried.
/// @throws model::Error kMapInvalid or kGridTooSmall if no cut gave a valid map
[[nodiscard]] CutSearchResult search_cut(const TriMesh& component, const CutSearchOptions& options,
                                         const model::Progress& progress);

}  // namespace dgm::bake
