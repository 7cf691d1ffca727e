// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/surface_checks.h
// Layers against the surface they describe: seams, topology, bounds, collision, cover, contact.
#pragma once
#include "geometry/metrics/map_metrics.h"
#include "geometry/metrics/reconstruction.h"
#include "validate/finding_list.h"

namespace dgm::validate {

/// @param chart  passed check_layers
/// @return the topology of the welded reconstruction, for the comparison with the report
bake::Topology check_surface(const model::Chart& chart, std::size_t chart_index,
                             const bake::Reconstruction& reconstruction, FindingList& findings);

}  // namespace dgm::validate
