// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/search/size_search.h
// Finds the grid for "at most this error", "at most these bytes", "at most so many samples". Nothing here bakes: the
// callers hand in a function that measures one grid.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "baking/bake_options.h"

namespace dgm::bake {

/// The largest grid of about `aspect` = (rows - 1) : (cols - 1) with at most `samples` samples. Both sides have an even
/// number of intervals, so that a level of detail by stride 2 keeps the borders, and lie within kMinSide..kMaxSide.
[[nodiscard]] GridSize grid_of(std::uint64_t samples, double aspect);

/// Grids of the aspect of `largest`, small to large: the longer side has 2, 4, 6, ... intervals; in steps of 2 up to
/// 128, then of 4, 8, ... for each doubling if `coarse` (so that a grid is 2 to 3 % finer than the one before it and a
/// search by measurement ends). Ends with `largest` itself, whatever its intervals.
[[nodiscard]] std::vector<GridSize> grid_ladder(GridSize largest, bool coarse);

/// Result of one grid of a ladder.
struct SizeTrial {
    std::size_t step = 0;  ///< index into the ladder
    double value = 0;      ///< infinity: there is no valid map on this grid
};

struct SizeSearch {
    std::optional<std::size_t> found;  ///< index into the ladder
    std::vector<SizeTrial> trials;     ///< in the order measured; none twice
    bool given_up = false;             ///< not found, and larger grids were not tried: the error falls too slowly
};

/// Measures one grid of a ladder; infinity if it holds no valid map.
using MeasureStep = std::function<double(std::size_t step)>;

/// The smallest grid whose error is at most `asked`, where the grid before it was measured and is above it. The error
/// is taken to fall as a power of the spacing of the samples (the square, until two measurements say otherwise), the
/// crossing is predicted from the nearest measurements on either side and measured, and the bracket is closed: four to
/// seven measurements for ladders of hundreds of grids. Starts at `first`; goes at most four times finer at once, so
/// that a first guess on a poor grid does not cost a huge one. Gives up where even a slope one power steeper than the
/// measured one would not hold `asked` on the last grid.
[[nodiscard]] SizeSearch smallest_that_holds(std::span<const GridSize> ladder, double asked, std::size_t first,
                                             const MeasureStep& measure);

/// The largest grid with at most `budget` bytes, where the next one was measured and is larger. Bytes are taken to grow
/// linearly with the samples. found is empty if the ladder's first grid is too large, or the largest that fits holds no
/// valid map.
[[nodiscard]] SizeSearch largest_that_fits(std::span<const GridSize> ladder, double budget, std::size_t first,
                                           const MeasureStep& measure);

/// One cheap bake of a grid of some aspect.
struct AspectTrial {
    GridSize size;
    double rms = 0;           ///< infinity: no valid map
    double chart_aspect = 0;  ///< free charts: height : width of the chart before it was stretched over the square
};
using MeasureAspect = std::function<AspectTrial(GridSize)>;

struct AspectChoice {
    double aspect = 1;  ///< (rows - 1) : (cols - 1), between 1/4 and 4 or as far as was asked (free charts: 1/8 and 8)
    double rms = 0;     ///< of its trial
    std::vector<AspectTrial> trials;
};

/// Aspects of a square chart that choose_aspect() tries, as powers of sqrt 2.
struct AspectRange {
    int longest = 4;
    int first = 2;     ///< beside 1:1, either way; at least 2
    bool near = true;  ///< whether those beside 1:1 are tried where the first gain nothing
};

/// The aspect with the least measured error at `samples` samples. A free chart has one, that of its rectangle. For a
/// square one: 1:1 and the range's first either way, from the best of them on twice as long or short as long as that
/// is better, then the neighbours (by sqrt 2) of the best. Another aspect than 1:1 must be better by 2 %.
[[nodiscard]] AspectChoice choose_aspect(std::uint64_t samples, const MeasureAspect& measure, AspectRange range = {});

/// grid_of(), but with numbers of intervals that 8 divides where both sides have at least 33 samples: three levels of
/// detail keep the borders then.
[[nodiscard]] GridSize even_grid_of(std::uint64_t samples, double aspect);

}  // namespace dgm::bake
