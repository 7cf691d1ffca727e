// SPDX-License-Identifier: GPL-3.0-or-later
// cli/edit/texture_padding.h
// Texels of a free chart that no face covers have the colour of their nearest covered one, so that filtering does not
// bleed another colour in. Paint on that one reaches them, too.
#pragma once
#include <cstdint>
#include <span>

#include "model/map_set.h"

namespace dgm::edit {

/// Colours those texels beyond the surface whose nearest covered texel was changed, by the bake's own rule
/// (geometry/layers/dilate.h). Texels that were painted themselves keep their paint.
/// @param changed  one a texel
/// @return how many have another colour now
std::uint64_t pad_texture(const model::Chart& chart, std::span<const char> changed, model::Layer& texture);

}  // namespace dgm::edit
