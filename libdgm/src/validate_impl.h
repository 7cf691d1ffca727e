// SPDX-License-Identifier: MIT
// libdgm/src/validate_impl.h
#pragma once
#include <dgm/allocator.h>
#include <dgm/result.h>

#include "chart_tables.h"

namespace dgm::detail {

/// The checks of validate_chart() on tables already found.
[[nodiscard]] Result<void> check_values(const ChartTables& tables, const Allocator& allocator) noexcept;

}  // namespace dgm::detail
