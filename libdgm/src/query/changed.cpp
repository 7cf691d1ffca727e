// SPDX-License-Identifier: MIT
// libdgm/src/query/changed.cpp
#include <dgm/changed.h>

#include "touch/state_impl.h"

namespace dgm {

Result<std::size_t> changed_rows(const State& state, std::uint64_t& cursor, std::span<ChangedRange> ranges) noexcept {
    const detail::StateImpl& s = *state.impl();
    detail::Changes& changes = s.changes;
    if (ranges.size() < (changes.grid.border != 0 ? 2u : 1u))
        return Error{ErrorCode::BufferTooSmall, kNoOffset, "there is no room for the ranges"};
    changes.bring_up();
    const std::uint64_t since = cursor > changes.epoch ? 0 : cursor;
    cursor = changes.epoch;
    if (since == changes.epoch) return std::size_t{0};
    detail::RangeWriter writer(changes.grid, ranges);
    writer.reserve(changes.border_latest > since && changes.grid.border != 0 ? 1 : 0);
    changes.each_run(
        since, [&](std::uint32_t row, std::uint32_t first, std::uint32_t last) { writer.add_row(row, first, last); },
        [&](std::uint32_t first, std::uint32_t last) { writer.add_border(first, last); });
    return writer.count();
}

}  // namespace dgm
