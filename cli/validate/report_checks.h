// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/report_checks.h
// The stored bake report against the file it stands in.
#pragma once
#include <optional>
#include <span>
#include <string>

#include "geometry/metrics/map_metrics.h"
#include "model/map_set.h"
#include "validate/finding_list.h"

namespace dgm::validate {

/// Errors that the bake measured against its source: the default limits of a later comparison.
struct ClaimedError {
    std::optional<double> rms, hausdorff;  ///< source units
};

/// Compares charts (number, method, domain, rows, cols, seam gap) and topology. `topologies` has one entry a chart,
/// empty where the chart could not be reconstructed.
ClaimedError check_report(const model::MapSet& maps, std::span<const std::optional<bake::Topology>> topologies,
                          FindingList& findings);

}  // namespace dgm::validate
