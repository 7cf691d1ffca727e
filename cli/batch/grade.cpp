// SPDX-License-Identifier: GPL-3.0-or-later
// cli/batch/grade.cpp
#include "batch/grade.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace dgm::bake {
namespace {

constexpr std::uint64_t kManyTurned = 1000;

double percent(double length, const SurfaceError& error) {
    return 100 * length / error.diagonal;
}

bool is_far(const SurfaceError& error) {
    return percent(error.rms, error) > 0.5 || percent(error.hausdorff, error) > 5;
}

Grade grade_of(const ChartReport& chart) {
    if (chart.map.flips > 0 || !(chart.seam_gap == 0)) return Grade::kBad;
    return has_many_turned(chart) || !keeps_topology(chart) ? Grade::kLook : Grade::kGood;
}

}  // namespace

bool has_many_turned(const ChartReport& chart) {
    const auto triangles = static_cast<std::uint64_t>(2.0 * chart.rows * chart.cols * chart.utilisation);
    return chart.turned_faces > 0 && chart.turned_faces * kManyTurned > triangles;
}

bool keeps_topology(const ChartReport& chart) {
    return chart.source_topology.genus == chart.map_topology.genus &&
           chart.source_topology.boundary_loops == chart.map_topology.boundary_loops;
}

Grade grade_of(const BakeReport& report) {
    const SurfaceError& error = report.error;
    const double rms = percent(error.rms, error), worst = percent(error.hausdorff, error);
    if (!std::isfinite(rms) || !std::isfinite(worst) || is_far(error)) return Grade::kBad;
    Grade out = rms > 0.1 || worst > 1 || !report.warnings.empty() ? Grade::kLook : Grade::kGood;
    for (const ChartReport& chart : report.charts) out = std::max(out, grade_of(chart));
    return out;
}

std::string_view verdict_word(const BakeReport& report) {
    switch (grade_of(report)) {
        case Grade::kGood:
            return "good";
        case Grade::kLook:
            return "worth a look";
        case Grade::kBad:
            break;
    }
    return is_far(report.error) ? "far from the mesh" : "wrong";
}

}  // namespace dgm::bake
