// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/materials.h
// The units and materials that have names, and the numbers of a material in the order of the layer `material`.
#pragma once
#include <array>
#include <string_view>

#include <dgm/limits.h>
#include <dgm/physics.h>

#include "baking/option_names.h"

namespace dgm::bake {

/// Metres.
inline constexpr std::array kUnitNames{NamedValue<double>{"mm", 1e-3}, NamedValue<double>{"cm", 1e-2},
                                       NamedValue<double>{"m", 1.0}};

/// Tissue: the default of physics.h, the wall of a hollow organ with what lies around it. Fabrics: orders of magnitude
/// of plain-woven cotton of 150 g/m^2, denim of 450 and polyester satin of 120, along warp and weft alike. Bending is
/// what Kawabata's bending tester (KES-FB2) finds for such weights, 0.05, 0.4 and 0.02 gf cm^2/cm, in N m; the membrane
/// is the slope of its tensile test (KES-FB1) at small strains. Nothing pulls fabrics back to their rest place.
inline constexpr std::array kMaterialNames{NamedValue<Material>{"tissue", Material{}},
                                           NamedValue<Material>{"cotton", {2000, 0.2f, 5e-6f, 0, 0.15f, 2e-3f}},
                                           NamedValue<Material>{"denim", {5000, 0.2f, 4e-5f, 0, 0.45f, 2e-3f}},
                                           NamedValue<Material>{"satin", {1000, 0.2f, 2e-6f, 0, 0.12f, 2e-3f}}};

/// Keys of a material file. The entries of layer `material` behind the first are these, in this order.
struct MaterialKey {
    std::string_view name, unit;
    float Material::*field;
    bool needed;
    std::string_view meaning;
};
inline constexpr std::array kMaterialKeys{
    MaterialKey{"membrane", "N/m", &Material::membrane, true, "Young's modulus times thickness"},
    MaterialKey{"poisson", "", &Material::poisson, false, "Poisson's ratio [0.3]"},
    MaterialKey{"bending", "N m", &Material::bending, true, "stiffness against bending"},
    MaterialKey{"foundation", "N/m^3", &Material::foundation, false, "pull to the rest place by what lies around [0]"},
    MaterialKey{"density", "kg/m^2", &Material::density, true, "mass of an area"},
    MaterialKey{"viscosity", "s", &Material::viscosity, false, "stress by a rate of strain over that by strain [0]"}};
static_assert(kMaterialKeys.size() + 1 == kMaterialValues);

[[nodiscard]] constexpr std::array<float, kMaterialKeys.size()> numbers_of(const Material& material) {
    std::array<float, kMaterialKeys.size()> out{};
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = material.*kMaterialKeys[k].field;
    return out;
}

}  // namespace dgm::bake
