// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/layer_checks.h
// Each layer by itself: there, of the right type and shape, finite, in range (design section 4).
#pragma once
#include <cstring>

#include "model/map_set.h"
#include "validate/finding_list.h"

namespace dgm::validate {

/// @return true if types and shapes are right, so that the layers may be read together
bool check_layers(const model::Chart& chart, std::size_t chart_index, FindingList& findings);

/// Element `index` of a layer whose type and size have been checked.
template <class T>
[[nodiscard]] inline T element(const model::Layer& layer, std::size_t index) {
    T value;
    std::memcpy(&value, layer.bytes.data() + index * sizeof(T), sizeof(T));
    return value;
}

}  // namespace dgm::validate
