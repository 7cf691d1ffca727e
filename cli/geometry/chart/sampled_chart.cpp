// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/chart/sampled_chart.cpp
#include "geometry/chart/sampled_chart.h"

#include <dgm/grid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_set>

#include "geometry/mesh/triangle.h"

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

namespace {

/// Edges of the welded surface near the chart's border. Beside the end of a cut the samples before and after it are one
/// point, so a diagonal from each to the same inner sample would be one edge of four faces.
class WeldedEdges {
 public:
    explicit WeldedEdges(const SampledChart& chart) : chart_(chart) {}
    [[nodiscard]] bool has(std::size_t a, std::size_t b) const { return edges_.count(key(a, b)) != 0; }
    void add(std::size_t a, std::size_t b) { edges_.insert(key(a, b)); }

 private:
    [[nodiscard]] std::uint64_t key(std::size_t a, std::size_t b) const {
        const std::uint64_t x = chart_.representative[a], y = chart_.representative[b];
        return std::min(x, y) << 32 | std::max(x, y);
    }
    const SampledChart& chart_;
    std::unordered_set<std::uint64_t> edges_;
};

}  // namespace

bool splits_badly(const SampledChart& chart, std::uint32_t i, std::uint32_t j, unsigned diagonal) {
    constexpr double kFlat = 1e-3;  // height over the longest edge
    std::array<Vec3d, 2> areas;
    const auto triangles = quad_triangles(i, j, chart.n, diagonal);
    for (std::size_t k = 0; k < 2; ++k) {
        const Face& f = triangles[k];
        const std::array q{chart.positions[f[0]], chart.positions[f[1]], chart.positions[f[2]]};
        areas[k] = cross(q[1] - q[0], q[2] - q[0]);
        if (length(areas[k]) < kFlat * longest_edge_squared(q)) return true;
    }
    return dot(areas[0], areas[1]) < 0;
}

void choose_diagonals(SampledChart& chart, const SampleGrid& centres) {
    const std::uint32_t m = chart.m, n = chart.n;
    const bool square = chart.domain == layout::Domain::kSquare;  // a free chart's quads do not touch its border
    chart.diagonals.assign(std::size_t{m - 1} * (n - 1), 0);
    const auto on_border = [&](std::uint32_t i, std::uint32_t j) {
        return i == 0 || j == 0 || i + 2 == m || j + 2 == n;
    };
    WeldedEdges edges(chart);
    if (square)
        for (std::uint32_t i = 0; i + 1 < m; ++i)
            for (std::uint32_t j = 0; j + 1 < n; ++j) {
                if (!on_border(i, j)) continue;
                const std::size_t a = std::size_t{i} * n + j, b = a + n, c = b + 1, d = a + 1;
                edges.add(a, b);
                edges.add(b, c);
                edges.add(c, d);
                edges.add(d, a);
            }
    const auto squared = [](const Vec3d& v) { return dot(v, v); };
    for (std::uint32_t i = 0; i + 1 < m; ++i)
        for (std::uint32_t j = 0; j + 1 < n; ++j) {
            const std::size_t a = std::size_t{i} * n + j, b = a + n, c = b + 1, d = a + 1;
            std::uint8_t& diagonal = chart.diagonals[std::size_t{i} * (n - 1) + j];
            const SurfaceSample& centre = centres.samples[std::size_t{2 * i + 1} * centres.n + 2 * j + 1];
            if (centre.face == kNone) {
                diagonal =
                    squared(chart.positions[b] - chart.positions[d]) < squared(chart.positions[a] - chart.positions[c]);
            } else {
                const Vec3d truth = position_at(chart.disk->mesh, centre);
                diagonal = squared((chart.positions[b] + chart.positions[d]) * 0.5 - truth) <
                           squared((chart.positions[a] + chart.positions[c]) * 0.5 - truth);
            }
            if (const bool first = splits_badly(chart, i, j, 0); first != splits_badly(chart, i, j, 1))
                diagonal = first;
            if (!square || !on_border(i, j)) continue;
            const auto taken = [&](std::uint8_t which) {
                const std::size_t from = which == 0 ? a : b, to = which == 0 ? c : d;
                return chart.representative[from] == chart.representative[to] || edges.has(from, to);
            };
            if (taken(diagonal) && !taken(!diagonal)) diagonal = !diagonal;
            if (diagonal == 0)
                edges.add(a, c);
            else
                edges.add(b, d);
        }
}

Vec3d Lattice::nearest(const Vec3d& p) const {
    Vec3d out = low;
    if (step > 0)
        for (int k = 0; k < 3; ++k) out[k] += step * std::clamp(std::round((p[k] - low[k]) / step), 0.0, kCodes);
    return out;
}

bool Lattice::holds(const Vec3d& p) const {
    for (int k = 0; k < 3; ++k) {
        const double code = step > 0 ? (p[k] - low[k]) / step : 0;
        if (!(code > -0.5 && code < kCodes + 0.5)) return false;
    }
    return true;
}

Lattice lattice_around(const SampledChart& chart) {
    Vec3d lo{1e300, 1e300, 1e300}, hi{-1e300, -1e300, -1e300};
    for (std::size_t s = 0; s < chart.positions.size(); ++s) {
        if (!chart.on_surface(s)) continue;
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], chart.positions[s][k]);
            hi[k] = std::max(hi[k], chart.positions[s][k]);
        }
    }
    double extent = 0;
    for (int k = 0; k < 3; ++k) extent = std::max(extent, hi[k] - lo[k]);
    return {lo, extent / Lattice::kCodes};
}

std::size_t count_folded(const SampledChart& chart) {
    std::vector<Vec3d> normals;  // of the source, not normalised
    normals.reserve(chart.disk->mesh.faces.size());
    for (std::size_t f = 0; f < chart.disk->mesh.faces.size(); ++f) {
        const auto q = chart.disk->mesh.corners(f);
        normals.push_back(cross(q[1] - q[0], q[2] - q[0]));
    }
    const std::vector<Face> faces = chart.faces();
    return static_cast<std::size_t>(std::count_if(faces.begin(), faces.end(), [&](const Face& f) {
        const Vec3d own =
            cross(chart.positions[f[1]] - chart.positions[f[0]], chart.positions[f[2]] - chart.positions[f[0]]);
        return std::all_of(f.begin(), f.end(), [&](std::uint32_t s) {
            const std::uint32_t face = chart.samples[s].face;
            return face != kNone && dot(own, normals[face]) < 0;
        });
    }));
}

void place_samples(SampledChart& chart) {
    chart.positions.assign(chart.samples.size(), Vec3d{});
    for (std::size_t s = 0; s < chart.samples.size(); ++s) {
        const std::uint32_t rep = chart.representative[s];
        if (rep != s)
            chart.positions[s] = chart.positions[rep];  // a representative is lower than its copies
        else if (chart.samples[s].face != kNone)
            chart.positions[s] = position_at(chart.disk->mesh, chart.samples[s]);
    }
}

std::vector<SurfaceSample> coarsen(const SampleGrid& fine, std::uint32_t m, std::uint32_t n) {
    std::vector<SurfaceSample> out(std::size_t{m} * n);
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 0; j < n; ++j)
            out[std::size_t{i} * n + j] = fine.samples[std::size_t{2 * i} * fine.n + 2 * j];
    return out;
}

Topology welded_topology(const SampledChart& chart) {
    std::vector<Face> faces = chart.faces();
    for (Face& f : faces)
        for (std::uint32_t& s : f) s = chart.representative[s];
    return measure_topology(chart.positions.size(), faces);
}

bool holds_topology(const Topology& welded, const Topology& source) {
    return welded.manifold && welded.oriented == source.oriented && welded.degenerate_faces == 0 &&
           welded.components == source.components && welded.boundary_loops == source.boundary_loops &&
           welded.genus == source.genus;
}

SurfaceError quick_error(const TriMesh& component, const SampledChart& chart, std::uint64_t samples,
                         const ClosestPointIndex* source_index) {
    SurfaceErrorOptions options;
    constexpr std::uint64_t kDense = 4;  // points a sample and a face: more of them give the same result
    options.samples = std::min<std::uint64_t>(samples, kDense * (chart.samples.size() + component.faces.size()));
    options.vertices = false;
    options.source_index = source_index;
    return measure_surface_error(component, chart.surface(), options);
}

}  // namespace dgm::bake
