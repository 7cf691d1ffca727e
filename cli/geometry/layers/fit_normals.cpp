// SPDX-License-Identifier: GPL-3.0-or-later
// cli/geometry/layers/fit_normals.cpp
// Gauss-Newton on the direction of the interpolated normal g = sum b n: its length is free, so a row asks for |g| N.
#include <cmath>

#include "geometry/layers/fit_layers.h"
#include "geometry/layers/grid_least_squares.h"
#include "model/octahedral.h"

namespace dgm::bake {
namespace {
/// Sum of 1 - cos of the deviation.
double normal_deviation(std::span<const MatchedPoint> points, std::span<const Vec3d> truth,
                        const std::vector<Vec3d>& n) {
    double sum = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        Vec3d g;
        for (std::size_t c = 0; c < 3; ++c) g += n[points[k].sample[c]] * points[k].b[c];
        sum += 1 - dot(normalized(g), truth[k]);
    }
    return sum;
}
}  // namespace

void fit_normals(const LayerInput& in, std::span<const MatchedPoint> points, StoredNormals& normals) {
    constexpr int kRounds = 2, kIterations = 15;
    constexpr double kDamping = 0.02;
    constexpr double kLargestTurn = 0.5;  // cosine: a normal that would turn farther has too few points to go by
    const SampledChart& chart = in.chart;
    if (points.empty()) return;
    std::vector<Vec3d> truth(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) truth[k] = source_normal(chart.disk->mesh, points[k].at);
    std::vector<Vec3d> n = normals.decoded;
    double error = normal_deviation(points, truth, n);
    bool better = false;
    for (int round = 0; round < kRounds; ++round) {
        std::vector<GridRow<3>> rows;
        rows.reserve(points.size());
        for (std::size_t k = 0; k < points.size(); ++k) {
            const MatchedPoint& p = points[k];
            Vec3d g;
            for (std::size_t c = 0; c < 3; ++c) g += n[p.sample[c]] * p.b[c];
            const double l = length(g);
            if (l < 0.1 || dot(g, truth[k]) <= 0 || truth[k] == Vec3d{}) continue;
            const Vec3d gap = truth[k] * l - g;
            GridRow<3>& row = rows.emplace_back();
            for (std::size_t c = 0; c < 3; ++c) {
                row.unknown[c] = chart.representative[p.sample[c]];
                row.w[c] = chart.is_reversed(p.sample[c]) ? -p.b[c] : p.b[c];
            }
            row.unknown[3] = row.unknown[0];
            row.value = {gap.x, gap.y, gap.z};
            row.weight = 1 / (l * l);
        }
        const auto step = grid_least_squares<3>(rows, n.size(), kDamping, kIterations);
        std::vector<Vec3d> next = n;
        for (std::size_t s = 0; s < n.size(); ++s) {
            if (!chart.on_surface(s)) continue;
            const auto& d = step[chart.representative[s]];
            const Vec3d by{d[0], d[1], d[2]};
            const Vec3d moved = normalized(chart.is_reversed(s) ? n[s] - by : n[s] + by, n[s]);
            if (dot(moved, n[s]) > kLargestTurn) next[s] = moved;
        }
        const double now = normal_deviation(points, truth, next);
        if (!(now < error)) break;
        n = std::move(next);
        error = now;
        better = true;
    }
    if (!better) return;
    const std::size_t grid = chart.grid_count();
    for (std::size_t s = 0; s < n.size(); ++s) {
        if (!chart.on_surface(s)) continue;
        const model::OctahedralCode code = sample_code(chart, s, model::encode_octahedral(n[chart.representative[s]]));
        auto codes = s < grid ? values<std::int16_t>(normals.normal).subspan(2 * s, 2)
                              : values<std::int16_t>(*normals.border_normal).subspan(2 * (s - grid), 2);
        codes[0] = code[0];
        codes[1] = code[1];
        normals.decoded[s] = model::decode_octahedral(code);
    }
}

}  // namespace dgm::bake
