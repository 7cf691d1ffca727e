// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/component/cut_memory.h
// The cuts found for one component while several grids are tried.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "baking/attempt.h"
#include "geometry/cut_search/cut_search.h"

namespace dgm::bake {

enum class CutUse {
    kSearch,  ///< search for each grid anew, as for a grid that was named
    kReuse,   ///< take the best cut known from a similar grid, search only if there is none: one map a cut, not dozens
    kBest,    ///< search, and take a cut known from a similar grid if it is better here
};

/// A cut serves grids of similar size about equally well, and one search finds cuts that another misses. So taking the
/// best known cut is cheaper than a search for each grid and, over a series of grids, steadier. The cut that was chosen
/// for one grid stays chosen for similar grids of its aspect.
class CutMemory {
 public:
    using Cut = std::shared_ptr<const CutSearchResult>;  ///< not null; the memory and its users share one

    /// search_cut for options.m x options.n, or a cut that was found before, as `use` says; remembers the cuts that it
    /// finds. Cuts are compared by measured error on a grid of at most 257 a side, those of rings (options.rings) and
    /// others each among themselves.
    /// @throws as search_cut
    [[nodiscard]] Cut search(const TriMesh& component, const CutSearchOptions& options, CutUse use,
                             const model::Progress& progress);

 private:
    struct Found {
        std::uint32_t m, n;
        std::uint32_t rotation;  ///< on that grid
        BorderShares shares;
        bool chosen;  ///< by comparison
        Cut cut;
    };
    using Candidates = std::vector<Found>;
    [[nodiscard]] Candidates similar(const CutSearchOptions& options, bool chosen) const;
    /// The best of `candidates` on the grid; the first one's error if none has a valid map there.
    [[nodiscard]] Attempt<Cut> best_of(const Candidates& candidates, const TriMesh& component,
                                       const CutSearchOptions& options, const model::Progress& progress);
    [[nodiscard]] Cut fresh(const TriMesh& component, const CutSearchOptions& options, const model::Progress& progress);

    std::vector<Found> found_;
};

}  // namespace dgm::bake
