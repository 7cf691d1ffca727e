// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/metrics/same_places.h
// Which points of a list lie at the same place.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "model/vec.h"

namespace dgm::bake {

/// For each point the lowest index of one with equal coordinates. Takes time linear in their number.
[[nodiscard]] std::vector<std::uint32_t> first_at_same_place(std::span<const model::Vec3d> points);

}  // namespace dgm::bake
