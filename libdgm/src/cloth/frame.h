// SPDX-License-Identifier: MIT
// libdgm/src/cloth/frame.h
// A frame of a cloth, its arguments checked.
#pragma once
#include <span>

#include "cloth/cloth_impl.h"

namespace dgm::detail::cloth {

/// Puts the cloth where a shape of its state is, without velocity.
void place_at(ClothImpl& c, const ConstPlanes& shape) noexcept;
/// c.scene is made, pins are marked.
[[nodiscard]] ClothReport run_frame(ClothImpl& c, State& state, const ClothStep& o, std::span<const ToolInput> tools,
                                    std::span<StepTool> answers) noexcept;

}  // namespace dgm::detail::cloth
