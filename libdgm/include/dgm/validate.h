// SPDX-License-Identifier: MIT
// libdgm/include/dgm/validate.h
// The values of a chart's tables: what Asset::open leaves unread and per-tick code must be able to trust.
#pragma once
#include <dgm/allocator.h>
#include <dgm/asset.h>
#include <dgm/result.h>

namespace dgm {

/// Reads geometry, border layers, mask, diagonals, seams and the values that touches read (`deformation`, `contact`) of
/// a chart once and checks:
/// on-surface positions are finite (also after scaling to float) and within kMaxCoordinate (limits.h); mask and
/// diagonals are 0 or 1; border_uv lies in [0, 1]; border_faces are in range, on the surface and have three different
/// corners; E and G lie in 0 .. kMaxForm, |F| too, stiffness and mobility in 0 .. 1 on the surface; seam pairs are in
/// range and on the border (of the grid in a square domain, border samples in a free one), the representative is the
/// lowest index of its class, no copy stands twice; copies of a class hold the same stored bits. A chart that passes
/// cannot make any call of this library crash, abort or open a seam. Layers that are absent are not missed, but a free
/// domain needs its mask, and geometry of border samples if it has any.
///
/// @return NotFinite, BadValue, BadSeamTable, SeamGap, MissingLayer with the byte offset of the element; OutOfMemory.
/// Cost O(samples); takes 4 bytes a sample of scratch from `allocator` if there is a seam table.
[[nodiscard]] DGM_API Result<void> validate_chart(const Chart& chart, const Allocator& allocator = {}) noexcept;

}  // namespace dgm
