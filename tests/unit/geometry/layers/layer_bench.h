// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/layers/layer_bench.h
// Charts to make layers of: laid by hand on a bent square, or mapped by the baker.
#pragma once
#include <algorithm>
#include <functional>
#include <vector>

#include "geometry/chart/square_chart.h"
#include "geometry/cut/cut_graph.h"
#include "geometry/layers/layers.h"
#include "geometry/parameterize/square_border.h"
#include "geometry/repair/repair.h"
#include "support/meshes.h"

namespace dgm::bake {

template <class T>
[[nodiscard]] std::vector<T> read(const model::Layer& layer) {
    std::vector<T> out(layer.bytes.size() / sizeof(T));
    std::copy_n(layer.bytes.data(), layer.bytes.size(), reinterpret_cast<std::byte*>(out.data()));
    return out;
}

/// A chart with all that layers are made from.
struct Bench {
    SampledChart chart;
    Frame frame;
    StoredFrame stored;
    MaterialImages images;
    SampleGrid fine;
    [[nodiscard]] LayerInput input() const { return {chart, frame, stored, images, fine, std::nullopt}; }
};

/// The unit square with (2m-1) x (2n-1) vertices, bent by `place`: its map is the identity, and vertices are samples.
[[nodiscard]] inline Bench patch(std::uint32_t m, std::uint32_t n, const std::function<Vec3d(double, double)>& place) {
    Bench b;
    TriMesh mesh = test::grid_sheet(2 * m - 2, 2 * n - 2);
    for (const Vec3d& p : mesh.positions) b.chart.uv.push_back({p.x, p.y});
    for (Vec3d& p : mesh.positions) p = place(p.x, p.y);
    b.chart.m = m;
    b.chart.n = n;
    b.chart.method = "by hand";
    b.chart.disk = CutGraph(mesh).open();  // nothing is cut; corners are found in face order, so vertices move
    std::vector<Vec2d> uv(b.chart.uv.size());
    for (std::size_t v = 0; v < uv.size(); ++v) uv[v] = b.chart.uv[b.chart.disk->weld[v]];
    b.chart.uv = uv;
    b.fine = rasterize(b.chart.disk->mesh.faces, uv, 2 * m - 1, 2 * n - 1);
    b.chart.samples = coarsen(b.fine, m, n);
    for (std::uint32_t s = 0; s < b.chart.samples.size(); ++s) b.chart.representative.push_back(s);
    place_samples(b.chart);
    choose_diagonals(b.chart, b.fine);
    return b;
}

/// A ball of radius 3 about (10, 20, 30), or a torus there, mapped by the baker itself.
[[nodiscard]] inline Bench baked(const TriMesh& mesh, std::uint32_t m, std::uint32_t n, bool quantised,
                                 Vec3d centre = {10, 20, 30}) {
    Bench b;
    TriMesh source = mesh;
    for (Vec3d& p : source.positions) p += centre;
    RepairedMesh repaired = repair(source);
    b.frame = repaired.frame;
    for (TriMesh& component : repaired.components) complete_normals(component);  // as the pipeline does
    CutGraph cut(repaired.components.at(0));
    cut.cut_to_disk();
    const Disk disk = cut.open();
    b.chart =
        make_square_chart(disk, m, n, candidate_rotations(disk, m, n, 1).front(), *make_stretch_parameterizer(0), {});
    b.stored = choose_frame(b.frame, b.chart, quantised);
    b.fine = rasterize(b.chart.disk->mesh.faces, b.chart.uv, 2 * m - 1, 2 * n - 1);
    return b;
}

}  // namespace dgm::bake
