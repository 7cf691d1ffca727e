// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/bake_report.h
// Report of a bake. The part without times and paths is stored in the file under /report.
#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "baking/bake_options.h"
#include "geometry/metrics/map_metrics.h"
#include "geometry/metrics/surface_error.h"

namespace dgm::bake {

/// Changes of the repair, counted by kind ("welded vertices", 16). Zero counts are left out.
using RepairCounts = std::vector<std::pair<std::string, std::uint64_t>>;

struct CandidateReport {
    std::string method;
    double psnr = 0;         ///< 0 if the candidate failed
    std::string outcome;     ///< "chosen", "higher error", or why it failed
    double cpu_seconds = 0;  ///< map and measurement, without the cut that candidates share; not stored in the file
};

struct ChartReport {
    std::string method, domain;
    std::uint32_t rows = 0, cols = 0;
    std::uint64_t source_vertices = 0, source_faces = 0;
    SurfaceError error;
    MapMetrics map;
    double utilisation = 1, seam_gap = 0, cut_length = 0;  ///< cut_length in source units
    double cut_exposure = 0;           ///< mean over the seams' length of spatial/exposure.h; 0 without seams
    double volume_relative_error = 0;  ///< closed charts: (V_map - V_source) / V_source
    std::uint64_t seam_pairs = 0;
    std::uint64_t turned_faces = 0;  ///< triangles inverted against the source (metrics/turned_faces.h)
    Topology source_topology, map_topology;
    std::vector<CandidateReport> candidates;
};

struct StageTime {
    std::string stage;
    double seconds = 0;
    double cpu_seconds = 0;  ///< of all threads
};

/// One grid that was measured on the way to the one that was asked for.
struct GridTrial {
    std::uint32_t rows = 0, cols = 0;  ///< of the largest chart, or of chart `chart` where its shape was looked for
    double rms = 0, hausdorff = 0;     ///< source units; NaN: not measured
    std::uint64_t bytes = 0;           ///< of the .dgm; 0: not measured
    std::string outcome;               ///< "holds", "does not hold", "fits", "too large", or why there is no map
    double cpu_seconds = 0;            ///< not stored in the file
};

/// A trial of a grid before anything is measured.
[[nodiscard]] inline GridTrial not_measured(GridSize size) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    return {size.rows, size.cols, kNone, kNone, 0, "", 0};
}

enum class SearchGoal { kMaxError, kBudget, kSamples };

/// How the grid was found that was asked for by error, by file size, or by number of samples.
struct GridSearch {
    SearchGoal goal = SearchGoal::kSamples;
    std::optional<ErrorKind> kind;        ///< max-error: of the error
    double asked = 0, asked_percent = 0;  ///< max-error: source units, and % of the diagonal
    double reached = 0, reached_percent = 0;
    double margin = 0;                 ///< max-error: kept in hand, since another sample of points differs by so much
    std::uint64_t asked_bytes = 0;     ///< budget
    std::uint64_t asked_samples = 0;   ///< samples
    std::uint32_t rows = 0, cols = 0;  ///< the answer, of the largest chart
    std::vector<GridTrial> shapes, trials;  ///< shapes: cheap grids that chose the aspect; trials: in the order tried
    std::optional<GridTrial> next;          ///< max-error: the next smaller grid; budget: the next larger one
};

/// A layer of the file that dgm-edit has put into it after the bake.
struct MapEdit {
    std::string layer;  ///< as an artist calls it: "stiffness"
    std::uint64_t samples = 0;
    std::string source, source_hash;  ///< the file that it came from, without folder, and its XXH3-128
};

struct BakeReport {
    std::string source_name;
    std::string inputs_hash;  ///< of what the mesh names (up_to_date.h); empty: unknown
    /// Formats where only an import tells: the files that the mesh names, from its folder, and what it names in vain.
    std::vector<std::string> inputs, missing_inputs;
    std::uint64_t source_vertices = 0, source_faces = 0;
    SurfaceError error;             ///< whole asset: all charts against all components
    double worst_quantisation = 0;  ///< u16: half a step, source units; 0 for f32
    RepairCounts repairs;
    std::vector<std::string> warnings;  ///< plain language: "DGM3012: texture missing: skin.png; ..."
    std::vector<std::string> remarks;  ///< what was done as the file asks: "FBX unit of 1 cm: scaled by 0.01 to metres"
    std::vector<ChartReport> charts;
    std::vector<MapEdit> edits;           ///< in the order they were made; none in a map as it was baked
    std::optional<GridSearch> search;     ///< only if the grid was not named
    std::vector<StageTime> times;         ///< not stored in the file
    double cpu_seconds = 0;               ///< not stored in the file
    std::uint64_t peak_memory_bytes = 0;  ///< not stored in the file
};

/// Compact JSON with sorted keys; numbers print shortest round-trip. `with_times` adds the fields that differ from run
/// to run. Keys are the field names; error objects also hold psnr, rms_percent and hausdorff_percent (of the diagonal).
/// A number that is not finite is written as null.
[[nodiscard]] std::string to_json(const BakeReport& report, bool with_times);

/// The inverse of to_json: doubles come back to the bit, null as NaN, absent keys as the field's default.
/// @throws model::Error kInternal if `text` is not such an object
[[nodiscard]] BakeReport report_from_json(std::string_view text);

}  // namespace dgm::bake
