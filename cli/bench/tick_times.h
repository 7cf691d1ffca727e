// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/tick_times.h
// Compute times of many short turns, one by one.
#pragma once
#include <cstddef>
#include <functional>

#include "bench/statistics.h"

namespace dgm::bench {

struct TickTimes {
    Figure median, p99, p999;  ///< microseconds; five blocks of the turns
    Figure longest;            ///< of all turns, once
    std::size_t preempted = 0;
};

/// Runs turn(k) for k in 0 .. warm_up - 1 unmeasured, then times the next `ticks`. Turns in which the thread lost its
/// processor are counted, not timed: the figure is time of computing, not of waiting. Of a block in which each turn
/// lost it (long ones on a busy machine), the processor time of its turns counts. `set_up(k)` runs before each turn,
/// outside the clock. @throws model::Error kInterrupted
[[nodiscard]] TickTimes time_ticks(std::size_t warm_up, std::size_t ticks,
                                   const std::function<void(std::size_t)>& set_up,
                                   const std::function<void(std::size_t)>& turn);

}  // namespace dgm::bench
