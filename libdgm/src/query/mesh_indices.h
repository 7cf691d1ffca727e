// SPDX-License-Identifier: MIT
// libdgm/src/query/mesh_indices.h
// The grid's connectivity as triangles or strips, at any stride.
#pragma once
#include <span>

#include <dgm/reconstruct.h>

#include "file/chart_tables.h"

namespace dgm::detail {

/// Writes indices to `out` and counts them; an empty span only counts. `out` has room for the counted indices.
/// @return BadValue for a diagonal that is neither 0 nor 1 or a border face that names no sample.
[[nodiscard]] Result<std::uint64_t> make_indices(const ChartTables& tables, const ReconstructOptions& options,
                                                 std::span<std::uint32_t> out) noexcept;

/// A corner of a border face, for sure below `total`.
[[nodiscard]] std::uint32_t corner_of_face(const ChartTables& tables, std::size_t place) noexcept;

}  // namespace dgm::detail
