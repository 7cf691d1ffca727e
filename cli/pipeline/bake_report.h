// SPDX-License-Identifier: GPL-3.0-or-later
// cli/pipeline/bake_report.h
// What a bake tells about itself. The part without times and paths is stored in the file under /report.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/metrics/map_metrics.h"
#include "geometry/metrics/surface_error.h"

namespace dgm::bake {

/// What repair changed, by kind ("welded vertices", 16) and zero counts left out.
using RepairCounts = std::vector<std::pair<std::string, std::uint64_t>>;

struct CandidateReport {
    std::string method;
    double psnr = 0;       ///< 0 if the candidate failed
    std::string outcome;   ///< "chosen", "higher error", or why it failed
};

struct ChartReport {
    std::string method, domain;
    std::uint32_t rows = 0, cols = 0;
    std::uint64_t source_vertices = 0, source_faces = 0;
    SurfaceError error;
    MapMetrics map;
    double utilisation = 1, seam_gap = 0, cut_length = 0;  ///< cut_length in source units
    double volume_relative_error = 0;  ///< closed charts: (V_map - V_source) / V_source
    std::uint64_t seam_pairs = 0;
    std::uint64_t turned_faces = 0;    ///< triangles that look against the source (metrics/turned_faces.h)
    Topology source_topology, map_topology;
    std::vector<CandidateReport> candidates;
};

struct StageTime {
    std::string stage;
    double seconds = 0;      ///< by the clock on the wall
    double cpu_seconds = 0;  ///< of all threads
};

struct BakeReport {
    std::string source_name;
    std::uint64_t source_vertices = 0, source_faces = 0;
    SurfaceError error;                  ///< whole asset: all charts against all components
    double worst_quantisation = 0;       ///< u16: half a step, source units; 0 for f32
    RepairCounts repairs;
    std::vector<std::string> warnings;   ///< plain language: "texture missing: skin.png"
    std::vector<ChartReport> charts;
    std::vector<StageTime> times;        ///< not stored in the file
    double cpu_seconds = 0;              ///< not stored in the file
    std::uint64_t peak_memory_bytes = 0; ///< not stored in the file
};

/// Compact JSON with sorted keys; numbers print shortest round-trip. `with_times` adds what differs from run to run.
/// Keys are the field names; error objects also hold psnr, rms_percent and hausdorff_percent (of the diagonal). A number
/// that is not finite is written as null.
[[nodiscard]] std::string to_json(const BakeReport& report, bool with_times);

/// The inverse of to_json: doubles come back to the bit, null as NaN, absent keys as the field's default.
/// @throws model::Error kInternal if `text` is not such an object
[[nodiscard]] BakeReport report_from_json(std::string_view text);

}  // namespace dgm::bake
