// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/layer_checks.h
// Each layer by itself: there, of the right type and shape, finite, in range (docs/design.md section 4).
#pragma once
#include <cstdint>

#include "model/map_set.h"
#include "validate/finding_list.h"

namespace dgm::validate {

/// Of a chart whose layer `border_geometry`, if there is one, has its shape.
[[nodiscard]] std::uint64_t border_samples(const model::Chart& chart);

/// @return true if types and shapes are right, so that the layers may be read together
bool check_layers(const model::Chart& chart, std::size_t chart_index, FindingList& findings);

}  // namespace dgm::validate
