// SPDX-License-Identifier: GPL-3.0-or-later
// tests/support/sheet_chart.h
// A chart whose every number is known: a sheet over the unit square, mapped by its x and y.
#pragma once
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "geometry/cut/cut_graph.h"
#include "geometry/fit/fit_state.h"
#include "support/meshes.h"

namespace dgm::bake::fit_test {

/// `side` x `side` samples of a sheet of cells x cells quads that lies `height(x, y)` above the square. Sample (i, j)
/// is at x = i / (side - 1), y = j / (side - 1); all diagonals run from (i, j) to (i + 1, j + 1).
template <class Height>
SampledChart sheet_chart(std::uint32_t side, std::uint32_t cells, Height height) {
    TriMesh mesh = test::grid_sheet(cells, cells);
    for (Vec3d& p : mesh.positions) p.z = height(p.x, p.y);
    SampledChart chart;
    chart.m = chart.n = side;
    chart.disk = CutGraph(mesh).open();
    for (const Vec3d& p : chart.disk->mesh.positions) chart.uv.push_back({p.x, p.y});
    chart.samples = rasterize(chart.disk->mesh.faces, chart.uv, side, side).samples;
    chart.representative.resize(chart.samples.size());
    std::iota(chart.representative.begin(), chart.representative.end(), 0U);
    chart.diagonals.assign(std::size_t{side - 1} * (side - 1), 0);
    place_samples(chart);
    return chart;
}

inline SampledChart flat_chart(std::uint32_t side, std::uint32_t cells) {
    return sheet_chart(side, cells, [](double, double) { return 0.0; });
}

/// Facets in one corner of a plane: an even map has too few samples there to follow their edges.
inline SampledChart rough_corner() {
    return sheet_chart(33, 40, [](double x, double y) {
        return x < 0.3 && y < 0.3 ? 0.03 * std::sin(61 * x + 7 * y) * std::cos(67 * y - 9 * x) : 0;
    });
}

/// Faces that look down.
inline std::vector<std::uint32_t> faces_upside_down(const LinkedSurface& surface) {
    std::vector<std::uint32_t> out;
    for (std::uint32_t f = 0; f < surface.faces.size(); ++f) {
        const auto q = surface.corners(f);
        if (cross(q[1] - q[0], q[2] - q[0]).z < 0) out.push_back(f);
    }
    return out;
}

/// A chart with all the parts of a fit around it.
struct FitCase {
    SampledChart chart;
    FitState fit;

    explicit FitCase(SampledChart made) : chart(std::move(made)), fit(chart, FitOptions{}) { fit.matches.update(true); }
    [[nodiscard]] std::uint32_t class_at(std::uint32_t i, std::uint32_t j) const {
        return fit.grid.class_of[i * chart.n + j];
    }
    [[nodiscard]] Vec3d& position(std::uint32_t c) { return fit.grid.surface.positions[c]; }
    /// After positions have changed.
    void look() {
        fit.grid.surface.update_normals();
        fit.matches.update(true);
    }
    /// Pulls sample (i, j) over its neighbour (i + 1, j), which inverts faces around it.
    void invert_at(std::uint32_t i, std::uint32_t j) {
        const double step = 1.0 / (chart.m - 1);
        position(class_at(i, j)) += Vec3d{1.5 * step, 0.3 * step, 0};
        look();
    }
};

}  // namespace dgm::bake::fit_test
