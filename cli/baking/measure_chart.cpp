// SPDX-License-Identifier: GPL-3.0-or-later
// cli/baking/measure_chart.cpp
#include "baking/measure_chart.h"

#include <algorithm>
#include <optional>

#include "geometry/cut_search/hidden_cut.h"
#include "geometry/metrics/bump_normals.h"
#include "geometry/metrics/reconstruction.h"
#include "geometry/metrics/turned_faces.h"

namespace dgm::bake {
namespace {

// Nobody looks at one chart of thousands: a chart gets its share of the points, but ChartMeasuring::least, and of these
// at least so many.
constexpr double kLeastTops = 8, kLeastSeamPoints = 64;

/// Six times the signed volume.
double six_volume(const TriMesh& mesh) {
    double sum = 0;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const auto q = mesh.corners(f);
        sum += dot(q[0], cross(q[1], q[2]));
    }
    return sum;
}

}  // namespace

MeasuredChart measure_chart(const TriMesh& component, const SampledChart& chart, const model::Chart& stored,
                            const Frame& frame, const ChartMeasuring& measuring, const model::Progress& progress) {
    MeasuredChart out;
    Reconstruction reconstruction = reconstruct(stored);
    TriMesh& map = reconstruction.mesh;
    const std::optional<BumpNormals> bump = BumpNormals::of(stored, reconstruction);
    for (Vec3d& p : map.positions) p = (p - frame.centre) / frame.diagonal;
    ChartReport& report = out.report;
    report.method = chart.method;
    report.domain = chart.domain == layout::Domain::kSquare ? "square" : "free";
    report.rows = chart.m;
    report.cols = chart.n;
    report.source_vertices = component.positions.size();
    report.source_faces = component.faces.size();
    report.seam_gap = reconstruction.seam_gap;
    report.cut_length = chart.cut_length * frame.diagonal;
    report.cut_exposure = seam_exposure(*chart.disk, component,
                                        static_cast<int>(std::max(kLeastSeamPoints, kSeamPoints * measuring.share)));
    report.map = measure_map(chart.disk->mesh.positions, chart.disk->mesh.faces, chart.uv);
    std::size_t used = 0;
    for (std::size_t s = 0; s < chart.grid_count(); ++s) used += chart.on_surface(s);
    report.utilisation = static_cast<double>(used) / static_cast<double>(chart.grid_count());
    for (std::size_t s = 0; s < chart.representative.size(); ++s) report.seam_pairs += chart.representative[s] != s;
    report.source_topology = measure_topology(component);
    report.map_topology = measure_topology(map.positions.size(), reconstruction.welded_faces);
    if (report.source_topology.boundary_loops == 0 && report.source_topology.oriented) {
        const double truth = six_volume(component);
        if (truth != 0) report.volume_relative_error = six_volume(map) / truth - 1;
    }
    std::optional<ClosestPointIndex> own;
    const ClosestPointIndex& index =
        measuring.source_index != nullptr ? *measuring.source_index : own.emplace(component.positions, component.faces);
    report.turned_faces = count_turned_faces(component, map, &index, faces_beside_reversed(reconstruction));
    SurfaceErrorOptions sampling;
    const auto most =
        std::max(measuring.least, static_cast<std::uint64_t>(static_cast<double>(measuring.samples) * measuring.share));
    sampling.samples = surface_samples(component, map, most);
    sampling.tops = static_cast<std::size_t>(std::max(kLeastTops, kSurfaceTops * measuring.share));
    sampling.source_index = &index;
    if (bump) sampling.shading = [&](std::uint32_t face, const double(&b)[3]) { return bump->at(face, b); };
    report.error = measure_surface_error(component, map, sampling, progress);
    out.surface = std::move(map);
    return out;
}

}  // namespace dgm::bake
