// SPDX-License-Identifier: GPL-3.0-or-later
// tests/fuzz/random_maps.h
// Makes maps of every kind that validate_chart() lets pass, and some that it must refuse.
#pragma once
#include <vector>

#include "dgm_builder.h"
#include "support/dice.h"

namespace dgm::test {

/// One chart of 2 x 2 to 33 x 33 samples: square (open, a tube, a torus, folded, an octahedron, any pairs of its
/// border) or free (mask, strip, further faces, any classes), f32 or u16, every optional layer now and then, all values
/// legal.
[[nodiscard]] ChartSpec random_chart(Dice& dice);

/// Overwrites a few elements of its layers by anything.
void spoil(Dice& dice, ChartSpec& chart);

}  // namespace dgm::test
