// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/source_checks.h
// The reconstruction against the mesh it was baked from.
#pragma once
#include <optional>
#include <span>

#include "geometry/metrics/map_metrics.h"
#include "validate/finding_list.h"
#include "validate/report_checks.h"
#include "validate/validation.h"

namespace dgm::validate {

/// Adds a chart's surface to one mesh of the whole asset. Corner normals stay only while every chart has them.
void append_mesh(model::TriMesh& whole, const model::TriMesh& part);

/// A file that passed the checks of its own.
struct SourceComparison {
    const model::MapSet& maps;
    const model::TriMesh& surface;      ///< all charts
    std::span<const char> either_side;  ///< of its faces, as find_turned_faces() takes them
    std::span<const std::optional<bake::Topology>> topologies;
    const ClaimedError& claimed;
};

/// Hash, distances, topology, inverted faces; `options.source` must be there. Fills in out.error and out.turned_faces.
void check_source(const SourceComparison& file, const Options& options, FileValidation& out, FindingList& findings);

}  // namespace dgm::validate
