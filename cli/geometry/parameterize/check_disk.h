// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/parameterize/check_disk.h
#pragma once
#include "geometry/parameterize/parameterizer.h"

namespace dgm::bake {

/// Refuses a mesh that is no disk, before a solver gets it: one component, one border that is the border of the faces
/// with the surface on its left, genus 0, manifold, oriented, finite, every vertex used; with `needs_border_uv`, one
/// point of the unit square per border vertex.
/// @throws model::Error kMapInvalid, kTooLarge
void check_disk(const DiskView& disk, bool needs_border_uv);

}  // namespace dgm::bake
