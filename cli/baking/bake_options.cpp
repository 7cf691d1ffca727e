// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/bake_options.cpp
#include "baking/bake_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "baking/materials.h"
#include "baking/option_names.h"
#include "dgm/hash.h"

namespace dgm::bake {
bool BakeOptions::ablates(std::string_view part) const {
    return std::find(ablate.begin(), ablate.end(), part) != ablate.end();
}

std::string canonical_settings(const BakeOptions& options) {
    // In file order and once each, so that --layers a,b and --layers b,a are the same settings.
    std::string layers;
    for (const std::string_view name : kLayerNames)
        if (std::find(options.layers.begin(), options.layers.end(), name) != options.layers.end())
            layers.append(layers.empty() ? "" : ",").append(name);
    std::string size = options.auto_samples ? fmt::format("auto:{}", *options.auto_samples)
                                            : fmt::format("{}x{}", options.size.rows, options.size.cols);
    if (options.any_aspect && !options.auto_samples) size += ";shape=any";
    if (options.max_error)
        size += fmt::format(";max_error={}{};max_error_kind={}", options.max_error->value,
                            options.max_error->percent ? "%" : "", name_of(kErrorKindNames, options.max_error->kind));
    if (options.budget_bytes) size += fmt::format(";budget={}", *options.budget_bytes);
    std::string text = fmt::format(
        "size={};method={};domain={};fit={};precision={};layers={};texture={};texture_size={}", size,
        name_of(options.method), name_of(kDomainNames, options.domain), name_of(kFitNames, options.fit),
        name_of(kPrecisionNames, options.precision), options.layers.empty() ? "all" : layers,
        options.texture.empty() ? "none" : formats::to_hex(formats::hash_file(options.texture)),
        options.texture_size ? fmt::format("{}x{}", options.texture_size->rows, options.texture_size->cols) : "grid");
    // Named only where they are used, so that files without them keep their hash.
    if (options.bump_size) text += fmt::format(";bump_size={}x{}", options.bump_size->rows, options.bump_size->cols);
    if (options.texture_bytes) text += fmt::format(";texture_bytes={}", *options.texture_bytes);
    if (options.texel_length) text += fmt::format(";texel_length={}", *options.texel_length);
    if (options.metres_per_unit) text += fmt::format(";metres_per_unit={}", *options.metres_per_unit);
    if (options.material)
        for (const float v : numbers_of(*options.material)) text += fmt::format(";material={}", v);
    for (const std::string_view name : kAblateNames)
        if (options.ablates(name)) text.append(";without=").append(name);
    return text;
}

}  // namespace dgm::bake
