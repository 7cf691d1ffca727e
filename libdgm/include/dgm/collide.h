// SPDX-License-Identifier: MIT
// libdgm/include/dgm/collide.h
// Finds the sample nearest to a tool and tests for a hit (paper section 5.1): a search of the whole surface at the
// start, then tracking in a window.
#pragma once
#include <cstdint>

#include <dgm/result.h>
#include <dgm/state.h>
#include <dgm/vec.h>

namespace dgm {

/// The sample nearest to a point.
struct Nearest {
    std::uint32_t sample = kNone;  ///< the lowest index if several are equally near
    float distance = 0;            ///< local units
};

/// Finds the nearest sample of the present shape exactly, through a pyramid of bounding boxes.
///
/// Boxes of tiles touched since the last query are refitted first, hence the non-const state. The answer equals that of
/// an exhaustive search with squared distances evaluated in float.
/// @return BadArgument if a coordinate of `tool` (local) is beyond kMaxCoordinate (limits.h), NotFound if the chart has
///         no sample.
/// No allocation. O(log samples) for a tool near the surface.
[[nodiscard]] DGM_API Result<Nearest> nearest_sample(State& state, Vec3 tool) noexcept;

/// Finds the nearest sample in the (2a + 1) x (2a + 1) window around `last`, continued across seams as in deform().
///
/// It can miss the true nearest sample if the tool jumped farther than the window or to another fold.
/// @return BadArgument: tool beyond kMaxCoordinate, `last` not on the surface, a >= StateOptions::max_reach.
///         LimitExceeded as in deform(). No allocation. O(a^2).
[[nodiscard]] DGM_API Result<Nearest> track_sample(State& state, Vec3 tool, std::uint32_t last,
                                                   std::uint32_t a) noexcept;

/// The sample nearest to a tracked tool.
struct Tracked {
    std::uint32_t sample = kNone;
    float distance = 0;  ///< local units
    bool lost = false;   ///< the window alone missed the sample
};

/// Gives the answer of nearest_sample(), but faster: the answer of track_sample() bounds a search of the pyramid, which
/// either confirms it or leads to the nearer sample.
/// @return as track_sample(). No allocation.
[[nodiscard]] DGM_API Result<Tracked> track_nearest(State& state, Vec3 tool, std::uint32_t last,
                                                    std::uint32_t a) noexcept;

/// Tests whether the tool touches (paper section 5.1): it does when N_t . N_n < 0.
///
/// @param tool_vector  N_t: from the nearest sample to the tool
/// @param normal       N_n: surface normal at the nearest sample (State::normal)
/// @return BadArgument if either is not finite.
[[nodiscard]] DGM_API Result<bool> hit_test(Vec3 tool_vector, Vec3 normal) noexcept;

}  // namespace dgm
