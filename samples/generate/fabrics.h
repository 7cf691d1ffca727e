// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/fabrics.h
// Woven cloth, thread by thread. Every picture tiles in both directions.
#pragma once
#include "image.h"

namespace dgm::samples {

/// 3/1 right-hand twill, indigo warp over white weft, uneven threads. Side in pixels.
Picture make_denim(int side);

/// 8-end satin in ruby: hardly a weave to see, soft streaks of sheen along the warp.
Picture make_satin(int side);

/// Plain-weave linen with woven stripes.
Picture make_striped_linen(int width, int height);

/// Plain-weave cotton in a check of two colours.
Picture make_gingham(int width, int height);

}  // namespace dgm::samples
