// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/repair/face_height.h
// Defines the faces without height.
#pragma once
#include <algorithm>
#include <array>

#include "model/vec.h"

namespace dgm::bake {

inline constexpr double kLeastHeightShare = 1e-10;  // of the longest edge

/// Height of a triangle above its longest edge, as a share of that edge; 0 if its corners coincide.
[[nodiscard]] inline double height_share(const std::array<model::Vec3d, 3>& q) {
    const double longest = std::max({length(q[1] - q[0]), length(q[2] - q[1]), length(q[0] - q[2])});
    if (!(longest > 0)) return 0;
    return length(cross((q[1] - q[0]) / longest, (q[2] - q[0]) / longest));
}

[[nodiscard]] inline bool without_height(const std::array<model::Vec3d, 3>& q) {
    return height_share(q) < kLeastHeightShare;
}

}  // namespace dgm::bake
