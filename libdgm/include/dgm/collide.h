// SPDX-License-Identifier: MIT
// libdgm/include/dgm/collide.h
// Tool against surface, paper section 5.1: nearest sample at start, then tracking in a window, then the hit test.
#pragma once
#include <cstdint>

#include <dgm/result.h>
#include <dgm/state.h>
#include <dgm/vec.h>

namespace dgm {

struct Nearest {
    std::uint32_t sample = kNone;  ///< of several equally near ones the lowest index
    float distance = 0;            ///< local units
};

/// Exact nearest sample of the present shape, by the box pyramid of docs/design.md section 4.
///
/// Boxes of tiles touched since the last query are refitted first, hence the non-const state. The answer is that of an
/// exhaustive search with squared distances evaluated in float.
/// @return BadArgument if a coordinate of `tool` (local) is beyond kMaxCoordinate (limits.h), NotFound if the chart has
///         no sample.
/// No allocation. O(log samples) for a tool near the surface.
[[nodiscard]] DGM_API Result<Nearest> nearest_sample(State& state, Vec3 tool) noexcept;

/// Nearest sample in the (2a + 1) x (2a + 1) window around `last`, continued across seams as in deform().
///
/// Can miss the true nearest one if the tool jumped farther than the window or to another fold.
/// @return BadArgument: tool beyond kMaxCoordinate, `last` not on the surface, a >= StateOptions::max_reach.
///         LimitExceeded as in deform(). No allocation. O(a^2).
[[nodiscard]] DGM_API Result<Nearest> track_sample(State& state, Vec3 tool, std::uint32_t last,
                                                   std::uint32_t a) noexcept;

struct Tracked {
    std::uint32_t sample = kNone;
    float distance = 0;  ///< local units
    bool lost = false;   ///< the window alone had missed it
};

/// track_sample() made certain: what the window found bounds a search of the pyramid, whose lower bounds either confirm
/// it or lead to the nearer sample. Never wrong: the answer of nearest_sample().
/// @return as track_sample(). No allocation.
[[nodiscard]] DGM_API Result<Tracked> track_nearest(State& state, Vec3 tool, std::uint32_t last,
                                                    std::uint32_t a) noexcept;

/// Paper section 5.1: the tool touches when N_t . N_n < 0.
///
/// @param tool_vector  N_t: from the nearest sample to the tool
/// @param normal       N_n: surface normal at the nearest sample (State::normal)
/// @return BadArgument if either is not finite.
[[nodiscard]] DGM_API Result<bool> hit_test(Vec3 tool_vector, Vec3 normal) noexcept;

}  // namespace dgm
