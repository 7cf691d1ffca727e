// SPDX-License-Identifier: MIT
// libdgm/src/touch/tool_slot.h
// A state's memory of one tool between ticks.
#pragma once
#include <cstdint>

#include <dgm/vec.h>

#include "rows/rows.h"

namespace dgm::detail {

struct ToolSlot {
    std::uint32_t kind = 0;
    bool placed = false;                  ///< `at` is the tool's place of the tick before
    bool holding = false;                 ///< in contact (touch, poke) or grasping
    std::uint32_t sample = 0xFFFFFFFFu;   ///< nearest sample of the tick before
    std::uint32_t contact = 0xFFFFFFFFu;  ///< sample the displacement is applied at
    Vec3 at;                              ///< tool position of the tick before
    Vec3 anchor;                          ///< poke and grasp: the tool's position when the contact began
    Vec3 wish;                            ///< displacement the contact asked for
    Vec3 carried;                         ///< rest of the jumps of `wish`, fading
    // Certificate: from `origin`, every sample of the base shape outside `patch` was at least `clear` away.
    bool certified = false;
    std::uint32_t base_version = 0;
    Rect patch;
    Vec3 origin;
    float clear = 0;
};

}  // namespace dgm::detail
