// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/result_figures.h
// Figures that the sweeps read from the result of a bake.
#pragma once
#include <algorithm>
#include <string>

#include "batch/batch_runner.h"
#include "bench/columns.h"
#include "bench/repeat.h"

namespace dgm::bench {

/// "DGM3003 MAP_INVALID".
[[nodiscard]] inline std::string error_name(const model::Error& error) {
    return error.code().id() + " " + error.code().name;
}

/// The methods that made the charts' maps, each once: "stretch, arap".
[[nodiscard]] inline std::string methods_of(const bake::AssetResult& result) {
    std::string out;
    for (const bake::ChartReport& chart : result.report.charts)
        if (out.find(chart.method) == std::string::npos) out += (out.empty() ? "" : ", ") + chart.method;
    return out;
}

/// L2 stretch of the worst chart.
[[nodiscard]] inline double worst_stretch(const bake::AssetResult& result) {
    double out = 0;
    for (const bake::ChartReport& chart : result.report.charts) out = std::max(out, chart.map.stretch_l2);
    return out;
}

[[nodiscard]] inline double cpu_seconds(const bake::AssetResult& result) {
    return result.report.cpu_seconds;
}

[[nodiscard]] inline double wall_seconds(const bake::AssetResult& result) {
    return result.seconds;
}

[[nodiscard]] inline double peak_mib(const bake::AssetResult& result) {
    return static_cast<double>(result.report.peak_memory_bytes) / (1U << 20U);
}

/// Fills bake_columns(): figures over the bakes of one point.
inline void set_bake(RowBuilder& row, const std::vector<bake::AssetResult>& results) {
    row.set("cpu_seconds", figure_of(results, cpu_seconds));
    row.set("wall_seconds", figure_of(results, wall_seconds));
    row.set("memory_mib", figure_of(results, peak_mib));
}

/// CPU seconds of a stage; writing has wall time alone. Only the grid that was written has stages of plain names.
[[nodiscard]] inline double stage_seconds(const bake::AssetResult& result, const std::string& stage) {
    for (const bake::StageTime& time : result.report.times)
        if (time.stage == stage) return time.cpu_seconds > 0 ? time.cpu_seconds : time.seconds;
    return 0;
}

}  // namespace dgm::bench
