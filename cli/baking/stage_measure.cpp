// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/stage_measure.cpp
// Errors of the layers as they are stored: measured in the normalised frame, then scaled to source units.
#include <cmath>
#include <numeric>
#include <utility>

#include "baking/chart_effort.h"
#include "baking/component/component_loop.h"
#include "baking/measure_chart.h"
#include "baking/stage_log.h"
#include "baking/stages.h"

namespace dgm::bake {
namespace {

/// Appends `part` to `whole`.
void append(TriMesh& whole, const TriMesh& part) {
    const auto base = static_cast<std::uint32_t>(whole.positions.size());
    whole.positions.insert(whole.positions.end(), part.positions.begin(), part.positions.end());
    for (const Face& f : part.faces) whole.faces.push_back({f[0] + base, f[1] + base, f[2] + base});
}

void to_source_units(SurfaceError& e, double diagonal) {
    for (double* x : {&e.rms, &e.hausdorff, &e.rms_forward, &e.rms_backward, &e.hausdorff_forward,
                      &e.hausdorff_backward, &e.diagonal})
        *x *= diagonal;
}

/// Each component's share of the area.
std::vector<double> shares_of(const std::vector<double>& areas) {
    const double area = std::accumulate(areas.begin(), areas.end(), 0.0);
    std::vector<double> out;
    out.reserve(areas.size());
    for (const double a : areas) out.push_back(area > 0 ? a / area : 1);
    return out;
}

/// The error of several charts together. Normals are measured chart by chart: each counts with its share of the area.
SurfaceError whole_error(const Repaired& source, std::vector<MeasuredChart>& measured,
                         const std::vector<double>& shares, std::uint64_t samples, const model::Progress& progress) {
    TriMesh whole_source, whole_map;
    for (std::size_t c = 0; c < measured.size(); ++c) {
        append(whole_source, source.components[c]);
        append(whole_map, measured[c].surface);
        measured[c].surface = {};
    }
    SurfaceError out = measure_surface_error(whole_source, whole_map,
                                             {.samples = surface_samples(whole_source, whole_map, samples)}, progress);
    double squared[3] = {0, 0, 0};
    for (std::size_t c = 0; c < measured.size(); ++c) {
        const SurfaceError& e = measured[c].report.error;
        const double degrees[3] = {e.normal_rms_degrees, e.normal_rms_face_degrees, e.normal_rms_bump_degrees};
        for (int k = 0; k < 3; ++k) squared[k] += shares[c] * degrees[k] * degrees[k];
    }
    out.normal_rms_degrees = std::sqrt(squared[0]);
    out.normal_rms_face_degrees = std::sqrt(squared[1]);
    out.normal_rms_bump_degrees = std::sqrt(squared[2]);
    return out;
}

}  // namespace

Measured measure_layers(const Repaired& source, const Fitted& fitted, const Layered& layered, std::uint64_t samples,
                        const model::Progress& progress) {
    const std::size_t count = fitted.charts.size(), parts = count > 1 ? 2 : 1;  // the charts, the whole
    const std::vector<double> shares = shares_of(source.areas);
    const std::uint64_t least = chart_effort(count, 1).measured_samples;
    std::vector<MeasuredChart> measured(count);
    for_each_component(count, part_of(progress, "measure", 0, parts), [&](std::size_t c, const model::Progress& part) {
        measured[c] = measure_chart(source.components[c], fitted.charts[c].chart, layered.charts[c], source.frame,
                                    {samples, least, shares[c], fitted.charts[c].source_index()}, part);
        for (const Candidate& candidate : fitted.charts[c].candidates)
            measured[c].report.candidates.push_back(report_of(candidate));
    });
    Measured out;
    out.error = count == 1 ? measured.front().report.error
                           : whole_error(source, measured, shares, samples, part_of(progress, "measure", 1, parts));
    to_source_units(out.error, source.frame.diagonal);
    for (MeasuredChart& chart : measured) {
        out.charts.push_back(std::move(chart.report));
        to_source_units(out.charts.back().error, source.frame.diagonal);
    }
    return out;
}

}  // namespace dgm::bake
