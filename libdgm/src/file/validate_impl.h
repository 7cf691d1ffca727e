// SPDX-License-Identifier: MIT
// libdgm/src/file/validate_impl.h
#pragma once
#include <cstddef>

#include <dgm/allocator.h>
#include <dgm/result.h>

#include "file/chart_tables.h"

namespace dgm::detail {

/// The checks of validate_chart() on tables already found.
[[nodiscard]] Result<void> check_values(const ChartTables& tables, const Allocator& allocator) noexcept;

/// Range of an element of layer `deformation`: E, F, G (0 .. 2) or the stiffness (3), which mobility shares.
[[nodiscard]] bool is_behaviour(std::size_t element, float value) noexcept;

}  // namespace dgm::detail
