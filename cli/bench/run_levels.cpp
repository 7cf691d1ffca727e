// SPDX-License-Identifier: GPL-3.0-or-later
// cli/bench/run_levels.cpp
// Level of detail by stride: triangles and time against the distance from the full grid.
#include <dgm/reconstruct.h>

#include "bench/repeat.h"
#include "bench/run_sweep.h"
#include "bench/runtime_error.h"
#include "bench/welded_surface.h"
#include "geometry/metrics/surface_error.h"

namespace dgm::bench {

Table level_table() {
    Table t;
    t.key = "levels";
    t.title = "Level of detail";
    t.note =
        "Triangles and vertices (positions and normals) of the present shape, made anew at every stride; errors are "
        "distances from the full grid's surface in % of its diagonal.";
    t.columns = subject_columns(
        {key_column("stride", "stride"), exact_column("triangles", "triangles", "", Sense::kLower),
         time_column("reconstruct_us", "reconstruct", "us"), time_column("indices_us", "indices alone", "us"),
         exact_column("rms_percent", "rms", "%", Sense::kLower, 0.01),
         exact_column("hausdorff_percent", "max", "%", Sense::kLower, 0.05)});
    t.plots = {{"Error against triangles", "triangles", "rms_percent", "grid", "asset", false}};
    return t;
}

void add_level_rows(Table& table, const Subject& subject) {
    const State state = subject.state();
    const model::TriMesh full = surface_of(state, 1, false);
    std::vector<float> vertices(std::size_t{6} * state.sample_count());
    VertexTarget target;
    target.memory = std::as_writable_bytes(std::span(vertices));
    target.stride = 6 * sizeof(float);
    target.normal_offset = 3 * sizeof(float);
    for (const std::uint32_t stride : {1U, 2U, 4U, 8U, 16U}) {
        ReconstructOptions options;
        options.lod_stride = stride;
        const MeshCounts counts = take(mesh_counts(state, options));
        std::vector<std::uint32_t> indices(counts.indices);
        SubjectRow row(table, subject);
        row.set("stride", std::to_string(stride));
        row.set("triangles", exactly(static_cast<double>(counts.indices) / 3));
        row.set("reconstruct_us",
                scaled(time_of_call([&] { (void)take(reconstruct(state, target, indices, options)); }), 1e6));
        row.set("indices_us", scaled(time_of_call([&] { (void)take(reconstruct(state, {}, indices, options)); }), 1e6));
        bake::SurfaceError error;
        if (stride > 1) {
            bake::SurfaceErrorOptions few;
            few.samples = 100'000;
            error = bake::measure_surface_error(full, surface_of(state, stride, false), few);
        }
        row.set("rms_percent", exactly(stride > 1 ? 100 * error.rms / error.diagonal : 0));
        row.set("hausdorff_percent", exactly(stride > 1 ? 100 * error.hausdorff / error.diagonal : 0));
        table.rows.push_back(row.row());
    }
}

}  // namespace dgm::bench
