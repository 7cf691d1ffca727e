// SPDX-License-Identifier: MIT
// libdgm/include/dgm/changed.h
// Lists the samples whose positions or normals changed, so that a renderer uploads those and no others.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include <dgm/result.h>
#include <dgm/state.h>

namespace dgm {

/// The samples first + r * cols + c for r < rows and c < columns: a rectangle of the grid. If `first` is at least
/// rows x cols of the grid, `rows` is 1 and the range is an interval of a free domain's border samples.
struct ChangedRange {
    std::uint32_t first = 0, columns = 0, rows = 0;
};

/// Lists where positions() or normals() of a state have other bits than when `cursor` was last passed here.
///
/// Every changed sample is in a range. Ranges contain more than that: columns are rounded out to multiples of eight,
/// contacts and fading are known by tiles of 8 x 8, and a list that does not fit is joined to fewer, larger ranges.
/// Ranges do not overlap unless they were joined. Normals count as they are: as of the last update_normals() or tick().
///
/// @param cursor  0 at first: then all samples are listed. Each reader keeps one of its own, and any number of readers
///                may call. A cursor belongs to one state; one from the future of this state counts as 0.
/// @param ranges  receives the list; 1 range is enough for a square domain, 2 for a free one
/// @return number of ranges written, 0 if nothing has changed; `cursor` is updated. BufferTooSmall if `ranges` is
///         smaller than that; then nothing has been written.
/// O(1) if nothing changed, else O(touched samples + rows / 8). No allocation. Brings faded displacements up to date.
[[nodiscard]] DGM_API Result<std::size_t> changed_rows(const State& state, std::uint64_t& cursor,
                                                       std::span<ChangedRange> ranges) noexcept;

}  // namespace dgm
