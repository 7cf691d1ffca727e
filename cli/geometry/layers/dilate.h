// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/dilate.h
// Fills texels that no face covers, so that filtering never bleeds in black.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/mesh/half_edges.h"  // kNone

namespace dgm::bake {

/// For each texel of rows x cols the covered one that it takes its colour from: itself if it is covered, else the
/// nearest in steps along rows and columns, of equally near ones the first that a search in texel order meets; kNone if
/// no texel is covered.
[[nodiscard]] std::vector<std::uint32_t> nearest_covered(std::span<const char> covered, std::uint32_t rows,
                                                         std::uint32_t cols);

}  // namespace dgm::bake
