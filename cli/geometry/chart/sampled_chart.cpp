// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/sampled_chart.cpp
#include "geometry/chart/sampled_chart.h"

#include <dgm/grid.h>

namespace dgm::bake {

bool SampledChart::has_quad(std::uint32_t i, std::uint32_t j) const {
    if (mask.empty()) return true;
    const std::size_t a = std::size_t{i} * n + j;
    return mask[a] && mask[a + 1] && mask[a + n] && mask[a + n + 1];
}

std::vector<Face> SampledChart::faces() const {
    std::vector<Face> out;
    out.reserve(2 * std::size_t{m - 1} * (n - 1) + strip.size());
    for (std::uint32_t i = 0; i + 1 < m; ++i)
        for (std::uint32_t j = 0; j + 1 < n; ++j) {
            if (!has_quad(i, j)) continue;
            const unsigned diagonal = diagonals.empty() ? 0u : diagonals[std::size_t{i} * (n - 1) + j];
            for (const Face& t : quad_triangles(i, j, n, diagonal)) out.push_back(t);
        }
    out.insert(out.end(), strip.begin(), strip.end());
    return out;
}

TriMesh SampledChart::surface() const {
    TriMesh mesh;
    mesh.positions = positions;
    mesh.faces = faces();
    return mesh;
}

void choose_diagonals(SampledChart& chart, const SampleGrid& centres) {
    const std::uint32_t n = chart.n;
    chart.diagonals.assign(std::size_t{chart.m - 1} * (n - 1), 0);
    const auto squared = [](const Vec3d& d) { return dot(d, d); };
    for (std::uint32_t i = 0; i + 1 < chart.m; ++i)
        for (std::uint32_t j = 0; j + 1 < n; ++j) {
            const std::size_t a = std::size_t{i} * n + j, b = a + n, c = b + 1, d = a + 1;
            std::uint8_t& diagonal = chart.diagonals[std::size_t{i} * (n - 1) + j];
            const auto& rep = chart.representative;
            if (rep[a] == rep[c] || rep[b] == rep[d]) {
                diagonal = rep[a] == rep[c];
                continue;
            }
            const Vec3d ac = (chart.positions[a] + chart.positions[c]) * 0.5, bd = (chart.positions[b] + chart.positions[d]) * 0.5;
            const SurfaceSample& centre = centres.samples[std::size_t{2 * i + 1} * centres.n + 2 * j + 1];
            if (centre.face == kNone) {
                diagonal = squared(chart.positions[b] - chart.positions[d]) < squared(chart.positions[a] - chart.positions[c]);
                continue;
            }
            const Vec3d truth = position_at(chart.disk.mesh, centre);
            diagonal = squared(bd - truth) < squared(ac - truth);
        }
}

void place_samples(SampledChart& chart) {
    chart.positions.assign(chart.samples.size(), Vec3d{});
    for (std::size_t s = 0; s < chart.samples.size(); ++s) {
        const std::uint32_t rep = chart.representative[s];
        if (rep != s)
            chart.positions[s] = chart.positions[rep];  // a representative is lower than its copies
        else if (chart.samples[s].face != kNone)
            chart.positions[s] = position_at(chart.disk.mesh, chart.samples[s]);
    }
}

std::vector<SurfaceSample> coarsen(const SampleGrid& fine, std::uint32_t m, std::uint32_t n) {
    std::vector<SurfaceSample> out(std::size_t{m} * n);
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < n; ++j) out[std::size_t{i} * n + j] = fine.samples[std::size_t{2 * i} * fine.n + 2 * j];
    return out;
}

SurfaceError quick_error(const TriMesh& component, const SampledChart& chart, std::uint64_t samples) {
    return measure_surface_error(component, chart.surface(), {samples, 1});
}

}  // namespace dgm::bake
