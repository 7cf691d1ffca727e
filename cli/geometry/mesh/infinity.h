// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/mesh/infinity.h
// The start of every search for a least value.
#pragma once
#include <limits>

namespace dgm::bake {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace dgm::bake
