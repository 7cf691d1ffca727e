// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/material.cpp
// Layer `material`: length of a unit and what the body is made of, for the physics of the runtime.
#include <algorithm>

#include "geometry/layers/layers.h"
#include "model/layer_names.h"

namespace dgm::bake {

void add_material(model::Chart& chart, double metres_per_unit, std::span<const float> material) {
    model::Layer layer = empty_layer(model::layers::kMaterial, model::ElementType::kF32, {1 + material.size()});
    values<float>(layer)[0] = static_cast<float>(metres_per_unit);
    std::copy(material.begin(), material.end(), values<float>(layer).begin() + 1);
    chart.layers.push_back(std::move(layer));
    if (model::Layer* geometry = chart.find(model::layers::kGeometry))
        geometry->attributes[model::layers::kMetresPerUnit] = std::vector<double>{metres_per_unit};
}

}  // namespace dgm::bake
