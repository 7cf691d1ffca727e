// SPDX-License-Identifier: GPL-3.0-or-later
// cli/worker/material_json.h
#pragma once
#include <nlohmann/json.hpp>

#include "baking/materials.h"

namespace dgm::bake {

/// The numbers of a material by the keys of material files.
[[nodiscard]] inline nlohmann::json material_json(const Material& material) {
    nlohmann::json out = nlohmann::json::object();
    for (const MaterialKey& key : kMaterialKeys) out[key.name] = material.*key.field;
    return out;
}

}  // namespace dgm::bake
