// SPDX-License-Identifier: MIT
// libdgm/include/dgm/changed.h
// Tells which samples' positions or normals changed, so that a renderer uploads those and no others.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include <dgm/result.h>
#include <dgm/state.h>

namespace dgm {

/// Samples first + r * cols + c, r < rows, c < columns: a rectangle of the grid, or (first >= rows x cols of the grid,
/// `rows` is 1) an interval of a free domain's border samples.
struct ChangedRange {
    std::uint32_t first = 0, columns = 0, rows = 0;
};

/// Where positions() or normals() of a state hold other bits than when `cursor` was last passed here.
///
/// Every changed sample is in a range. Ranges hold more than that: columns are rounded out to multiples of eight,
/// contacts and what fades are known by tiles of 8 x 8, and a list that would not fit is joined to fewer, larger
/// ranges. Ranges do not overlap unless they were joined. If nothing was written since, there is none. Normals count as
/// they stand: as of the last update_normals() or tick().
///
/// @param cursor  0 at first: then all samples are reported. Each reader keeps its own, and any number may read; a
///                cursor of another state is taken for 0 if it is from the future, else is the caller's mistake.
/// @param ranges  where to; 1 is enough for a square domain, 2 for a free one
/// @return how many ranges were written; `cursor` is now. BufferTooSmall if `ranges` is smaller than that; then nothing
///         was written.
/// O(1) if nothing changed, else O(touched samples + rows / 8). No allocation. What fades is brought up to date.
[[nodiscard]] DGM_API Result<std::size_t> changed_rows(const State& state, std::uint64_t& cursor,
                                                       std::span<ChangedRange> ranges) noexcept;

}  // namespace dgm
