// SPDX-License-Identifier: MIT
// libdgm/include/dgm/validate.h
// Checks the values of a chart's tables, which Asset::open() does not read and per-tick code relies on.
#pragma once
#include <dgm/allocator.h>
#include <dgm/asset.h>
#include <dgm/result.h>

namespace dgm {

/// Reads once the geometry, border layers, mask, diagonals, seams and the values that touches use (`deformation`,
/// `contact`), and checks them:
///  - positions on the surface are finite, also after scaling to float, and within kMaxCoordinate (limits.h);
///  - mask and diagonals are 0 or 1;
///  - border_uv lies in [0, 1];
///  - border_faces are in range, on the surface, and have three different corners;
///  - on the surface E and G lie in 0 .. kMaxForm, |F| too, stiffness and mobility in 0 .. 1;
///  - seam pairs are in range and on the border (of the grid in a square domain, border samples in a free one), the
///    representative is the lowest index of its weld class, and no copy is listed twice;
///  - `reversed` is as long as the list of pairs;
///  - copies of a class have the same stored bits.
/// No call of this library can crash, abort or open a seam on a chart that passes. Layers may be absent, but a free
/// domain needs its mask, and the geometry of border samples if it has any.
///
/// @return NotFinite, BadValue, BadSeamTable, SeamGap, MissingLayer with the byte offset of the element; OutOfMemory;
///         BadArgument (half an allocator).
/// O(samples); takes 4 bytes a sample of scratch memory from `allocator` if there is a seam table.
[[nodiscard]] DGM_API Result<void> validate_chart(const Chart& chart, const Allocator& allocator = {}) noexcept;

}  // namespace dgm
