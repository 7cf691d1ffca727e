// SPDX-License-Identifier: GPL-3.0-or-later
// samples/generate/upholstery.h
// Things of cloth, as quads. z up, centimetres; UVs within [0, 1].
#pragma once
#include "poly_mesh.h"

namespace dgm::samples {

/// Pillow: two bulging squares sewn together along a sharp rim, corners drawn out. Closed, genus 0. The UVs are one
/// chart, twice as wide as high: bottom left, top right, joined along one edge of the rim.
PolyMesh make_cushion();

/// Case for that cushion: a bag a little larger, open at +x, with slack folds. A disk; UVs as for the cushion.
PolyMesh make_cushion_cover();

/// Flat square of 40 x 40 quads, one metre wide.
PolyMesh make_sheet();

/// Flared skirt around the z axis: an elliptic waist of 32 x 24 cm at z = 0, 45 cm high, twice as wide at the hem. A
/// tube of 48 x 24 quads, open above and below.
PolyMesh make_skirt();

/// Chair seat: rounded box with a dished top and piping around it. Closed, genus 0; cloth tiles on every side.
PolyMesh make_chair_seat();

/// Chair back: the same build, upright, hollow towards the sitter, with five pulled-in buttons.
PolyMesh make_chair_back();

}  // namespace dgm::samples
