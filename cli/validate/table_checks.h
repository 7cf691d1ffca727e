// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/table_checks.h
// Layers that follow from the geometry: collision, cover, contact, deformation.
#pragma once
#include "validate/surface.h"

namespace dgm::validate {

/// @param s     finite, with faces in range
/// @param area  of all its faces
void check_tables(const Surface& s, double area, FindingList& findings);

}  // namespace dgm::validate
