// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/measure_chart.h
// Report of one chart, measured on its layers as they are stored.
#pragma once
#include <cstdint>

#include "baking/bake_report.h"
#include "baking/chart_effort.h"
#include "geometry/chart/sampled_chart.h"
#include "geometry/repair/repair.h"
#include "model/map_set.h"
#include "model/progress.h"

namespace dgm::bake {

struct ChartMeasuring {
    std::uint64_t samples = kSurfaceSamples;  ///< of the whole asset, each way
    std::uint64_t least = kLeastMeasured;     ///< of a chart, each way
    double share = 1;                         ///< of the asset's area, which decides how closely the chart is looked at
    const ClosestPointIndex* source_index = nullptr;  ///< of the component; null: one is built
};

struct MeasuredChart {
    ChartReport report;  ///< lengths in units of the frame's diagonal; without candidates
    TriMesh surface;     ///< as read back from the layers, in the normalised frame
};

/// @param component  in the normalised frame, as `chart`
/// @param stored  made of `chart`, in source units
/// Thread-safe. The same bits whatever the number of threads.
/// @throws model::Error kInternal if an index cannot be built, kInterrupted
[[nodiscard]] MeasuredChart measure_chart(const TriMesh& component, const SampledChart& chart,
                                          const model::Chart& stored, const Frame& frame,
                                          const ChartMeasuring& measuring, const model::Progress& progress);

}  // namespace dgm::bake
