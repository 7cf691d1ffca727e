// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/layers/fit_layers_test.cpp
#include "geometry/layers/fit_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/fit/closest_samples.h"
#include "geometry/layers/grid_least_squares.h"
#include "geometry/metrics/bump_normals.h"
#include "geometry/metrics/grid_point.h"
#include "layer_bench.h"
#include "model/half.h"

namespace dgm::bake {
namespace {

TEST(GridLeastSquares, IsTheLineThroughThePoints) {
    // Values of 1 + 2 t at t = 0.1, 0.4, 0.9 between two unknowns: 1 and 3; the second channel is the negative.
    std::vector<GridRow<2>> rows;
    for (const double t : {0.1, 0.4, 0.9}) rows.push_back({{0, 1, 0, 0}, {1 - t, t, 0, 0}, {1 + 2 * t, -1 - 2 * t}, 1});
    const auto x = grid_least_squares<2>(rows, 3, 0, 20);
    EXPECT_NEAR(x[0][0], 1, 1e-9);
    EXPECT_NEAR(x[1][0], 3, 1e-9);
    EXPECT_NEAR(x[0][1], -1, 1e-9);
    EXPECT_NEAR(x[1][1], -3, 1e-9);
    EXPECT_EQ(x[2][0], 0);  // in no row
}

TEST(GridLeastSquares, WeighsAndDamps) {
    // (3 * 4 + 1 * 8) / (3 + 1) = 5, and with damping of the own diagonal, 1/4 of it, 20 / (4 + 1).
    const std::vector<GridRow<1>> rows{{{0, 0, 0, 0}, {1, 0, 0, 0}, {4}, 3}, {{0, 0, 0, 0}, {1, 0, 0, 0}, {8}, 1}};
    EXPECT_NEAR(grid_least_squares<1>(rows, 1, 0, 5)[0][0], 5, 1e-12);
    EXPECT_NEAR(grid_least_squares<1>(rows, 1, 0.25, 5)[0][0], 4, 1e-12);
}

TEST(GridPoints, LieOnTheTriangleOfTheirDiagonal) {
    for (const unsigned d : {0u, 1u})
        for (const double x : {0.0, 0.2, 0.9, 1.3, 2.0})
            for (const double y : {0.0, 0.7, 1.0, 1.95, 3.0}) {
                const auto p = grid_point(
                    x, y, 3, 4, [](auto, auto) { return true; }, [&](auto, auto) { return d; });
                ASSERT_TRUE(p);
                double row = 0, col = 0, sum = 0;
                for (std::size_t k = 0; k < 3; ++k) {
                    EXPECT_GE(p->b[k], -1e-12);
                    row += p->b[k] * (p->sample[k] / 4);
                    col += p->b[k] * (p->sample[k] % 4);
                    sum += p->b[k];
                }
                EXPECT_NEAR(row, x, 1e-12);
                EXPECT_NEAR(col, y, 1e-12);
                EXPECT_NEAR(sum, 1, 1e-12);
            }
    // Only quad (0, 0) is there: its far corner is found, the middle of the next quad is not.
    const auto first = [](std::uint32_t i, std::uint32_t j) { return i == 0 && j == 0; };
    EXPECT_TRUE(grid_point(1, 1, 3, 4, first, [](auto, auto) { return 0u; }));
    EXPECT_FALSE(grid_point(1.5, 0.5, 3, 4, first, [](auto, auto) { return 0u; }));
}

TEST(TexelClasses, JoinWhatASeamJoins) {
    // 3 x 3 samples, the last column a copy of the first, upside down: (0,2) = (2,0), (1,2) = (1,0), (2,2) = (0,0).
    const std::vector<std::uint32_t> samples{0, 1, 2, 3, 4, 3, 2, 7, 0};
    const auto classes = texel_classes(3, 3, 5, 5, samples);
    const auto at = [&](int i, int j) { return classes[static_cast<std::size_t>(5 * i + j)]; };
    EXPECT_EQ(at(4, 0), at(0, 4));
    EXPECT_EQ(at(0, 0), at(4, 4));
    EXPECT_EQ(at(1, 0), at(3, 4));  // between samples too
    EXPECT_EQ(at(3, 0), at(1, 4));
    EXPECT_EQ(at(2, 0), at(2, 4));
    EXPECT_NE(at(1, 0), at(3, 0));
    EXPECT_NE(at(0, 1), at(4, 1));  // rows are no seam
    EXPECT_EQ(at(2, 2), 12u);
    // Nothing is known about other sizes.
    for (std::uint32_t t = 0; const std::uint32_t c : texel_classes(3, 3, 4, 5, samples)) EXPECT_EQ(c, t++);
}

TEST(HeightOver, MeetsThePlaneOfTheSource) {
    // Ray along z from the origin; the source's plane goes through (3, 0, 1) with a slope of 1/3: it is met at z = 2.
    const Vec3d normal = normalized(Vec3d{1, 0, 3});
    EXPECT_NEAR(height_over({}, {0, 0, 1}, {3, 0, 1}, normal), 2, 1e-12);
    EXPECT_NEAR(height_over({}, {0, 0, 1}, {0.5, 0, -1}, {0, 0, 1}), -1, 1e-12);
    // A steep plane is met far off or never: the projection instead.
    EXPECT_NEAR(height_over({}, {0, 0, 1}, {3, 0, 1}, {1, 0, 0}), 1, 1e-12);
}

/// A ball with dents finer than a 33 x 33 grid holds, or one of few faces, smoothly shaded. Its samples stay where they
/// were taken: a fit of the geometry would leave the layers little to do.
struct FittedBall {
    Bench bench;
    TriMesh component;
    explicit FittedBall(const TriMesh& mesh) {
        RepairedMesh repaired = repair(mesh);
        component = repaired.components.at(0);
        complete_normals(component);
        bench = baked(mesh, 33, 33, false, {});
        bench.fine = closest_samples(bench.chart, 65, 65);
    }
    [[nodiscard]] LayerInput input() const {
        LayerInput in = bench.input();
        in.fitted = true;
        return in;
    }
    /// Errors of the chart's layers against the source, in its normalised frame.
    [[nodiscard]] SurfaceError measure(const model::Chart& chart) const {
        Reconstruction surface = reconstruct(chart);
        const auto bump = BumpNormals::of(chart, surface);
        EXPECT_TRUE(bump);
        for (Vec3d& p : surface.mesh.positions) p = (p - bench.frame.centre) / bench.frame.diagonal;
        SurfaceErrorOptions options;
        options.samples = 30'000;
        options.shading = [&](std::uint32_t face, const double(&b)[3]) { return bump->at(face, b); };
        return measure_surface_error(component, surface.mesh, options);
    }
};

TriMesh bumpy_ball() {
    TriMesh mesh = test::icosphere(5, 3);
    for (Vec3d& p : mesh.positions) p *= 1 + 0.01 * std::sin(6 * p.x) * std::sin(6 * p.y) * std::sin(6 * p.z);
    return mesh;
}

double rms_degrees(const LayerInput& in, const std::vector<MatchedPoint>& points, const std::vector<Vec3d>& normals) {
    double sum = 0;
    for (const MatchedPoint& p : points) {
        Vec3d n;
        for (std::size_t k = 0; k < 3; ++k) n += normals[p.sample[k]] * p.b[k];
        const Vec3d truth = source_normal(in.chart.disk->mesh, p.at);
        const double angle = std::atan2(length(cross(n, truth)), dot(n, truth));
        sum += angle * angle;
    }
    return std::sqrt(sum / static_cast<double>(points.size())) * 180 / std::numbers::pi;
}

TEST(FitNormals, BeatSampledOnesAtOtherPoints) {
    const FittedBall ball(bumpy_ball());
    const LayerInput in = ball.input();
    const StoredPositions positions = store_positions(in);
    const StoredNormals sampled = store_normals(in);
    StoredNormals fitted = sampled;
    fit_normals(in, match_source(in, positions, 5 * 33 * 33), fitted);
    const std::vector<MatchedPoint> others = match_source(in, positions, 20'011);
    ASSERT_GT(others.size(), 19'000u);
    EXPECT_LT(rms_degrees(in, others, fitted.decoded), 0.95 * rms_degrees(in, others, sampled.decoded));
    const auto codes = read<std::int16_t>(fitted.normal);
    for (std::size_t s = 0; s < fitted.decoded.size(); ++s) {
        EXPECT_NEAR(length(fitted.decoded[s]), 1, 1e-6);
        const std::size_t rep = ball.bench.chart.representative[s];
        EXPECT_EQ(codes[2 * s], codes[2 * rep]);
        EXPECT_EQ(codes[2 * s + 1], codes[2 * rep + 1]);
    }
}

TEST(FitBump, ShadingWithItIsCloserToTheSource) {
    const FittedBall ball(bumpy_ball());
    const model::Chart chart = make_layers(ball.input(), {}).chart;
    const SurfaceError error = ball.measure(chart);
    EXPECT_LT(error.normal_rms_degrees, 0.95 * error.normal_rms_face_degrees);
    EXPECT_LT(error.normal_rms_bump_degrees, 0.85 * error.normal_rms_degrees);
    // The same without it is what a reader sees that knows no bump.
    model::Chart flat = chart;
    for (std::byte& b : flat.find("bump")->bytes) b = std::byte{0};
    flat.find("bump")->attributes["shading"] = std::vector<double>{0};
    EXPECT_DOUBLE_EQ(ball.measure(flat).normal_rms_bump_degrees, error.normal_rms_degrees);
}

TEST(FitBump, DoesNotShowTheFacetsOfASmoothlyShadedSource) {
    // 320 faces under a grid three times as fine: heights know the facets, the source's normals do not.
    const FittedBall ball(test::icosphere(2, 3));
    const SurfaceError error = ball.measure(make_layers(ball.input(), {}).chart);
    EXPECT_GT(error.normal_rms_face_degrees, 4);
    EXPECT_LT(error.normal_rms_bump_degrees, 1.001 * error.normal_rms_degrees);
}

TEST(FitBump, BothSidesOfASeamStandEquallyHigh) {
    const FittedBall ball(bumpy_ball());
    const model::Chart chart = make_layers(ball.input(), {}).chart;
    const auto bits = read<std::uint16_t>(*chart.find("bump"));
    const auto classes = texel_classes(33, 33, 65, 65, ball.bench.chart.representative);
    std::size_t joined = 0;
    for (std::size_t t = 0; t < bits.size(); ++t) {
        joined += classes[t] != t;
        EXPECT_EQ(bits[t], bits[classes[t]]);
    }
    EXPECT_GE(joined, 120u);  // a closed body: nearly half of the 256 texels of the border
}

TEST(FitBump, DisplacesTheGridTowardsTheSource) {
    const FittedBall ball(bumpy_ball());
    const LayerInput in = ball.input();
    const StoredPositions positions = store_positions(in);
    const StoredNormals normals = store_normals(in);
    const auto points = match_source(in, positions, 5 * 33 * 33);
    const model::Layer layer = make_bump(in, positions, normals, points);
    const auto bits = read<std::uint16_t>(layer);
    double without = 0, with = 0;
    for (const MatchedPoint& p : match_source(in, positions, 20'011)) {
        Vec3d grid, normal;
        for (std::size_t k = 0; k < 3; ++k) {
            grid += positions.local[p.sample[k]] * p.b[k];
            normal += normals.decoded[p.sample[k]] * p.b[k];
        }
        const Vec2d at = grid_coordinates(in.chart, p);
        const TexelTaps taps = texel_taps(2 * at.x, 2 * at.y, 65, 65);
        double h = 0;
        for (std::size_t k = 0; k < 4; ++k) h += taps.weight[k] * model::half_value(bits[taps.texel[k]]);
        const Vec3d truth = local_position(in, p.at), gap = truth - grid, rest = gap - normalized(normal) * h;
        without += dot(gap, gap);
        with += dot(rest, rest);
    }
    EXPECT_LT(with, 0.5 * without);
}

TEST(FitBump, TakesTheSizeAskedFor) {
    const FittedBall ball(test::icosphere(3, 3));
    LayerInput in = ball.input();
    in.bump_size = {97, 40};
    const model::Chart chart = make_layers(in, {}).chart;
    EXPECT_EQ(chart.find("bump")->shape, (std::vector<std::uint64_t>{97, 40}));
    EXPECT_LT(ball.measure(chart).normal_rms_bump_degrees, 1.001 * ball.measure(chart).normal_rms_degrees);
}

/// Interpolated texels against the source's colours at points in between.
double colour_error(const LayerInput& in, const std::vector<MatchedPoint>& points, const model::Layer& texture) {
    const auto rgba = read<std::uint8_t>(texture);
    const auto rows = static_cast<std::uint32_t>(texture.shape[0]), cols = static_cast<std::uint32_t>(texture.shape[1]);
    double sum = 0;
    for (const MatchedPoint& p : points) {
        const Vec2d at = grid_coordinates(in.chart, p);
        const TexelTaps taps =
            texel_taps(at.x * (rows - 1) / (in.chart.m - 1), at.y * (cols - 1) / (in.chart.n - 1), rows, cols);
        double red = 0, truth = 0;
        for (std::size_t k = 0; k < 4; ++k) red += taps.weight[k] * rgba[4 * taps.texel[k]];
        for (std::size_t k = 0; k < 3; ++k)
            truth += p.at.b[k] * in.chart.disk->mesh.corner_colours[3 * p.at.face + k].r;
        sum += (red - truth) * (red - truth);
    }
    return std::sqrt(sum / static_cast<double>(points.size()));
}

TEST(FitTexture, BeatsSampledColoursAndDoesNotRing) {
    // Stripes of 60 and 200, four to three texels: samples of them are a moire, their means are grey.
    Bench b = patch(13, 13, [](double x, double y) { return Vec3d{3 * x, 3 * y, 0}; });
    TriMesh& mesh = b.chart.disk.own().mesh;
    for (const Face& f : mesh.faces)
        for (std::uint32_t v : f) {
            const auto stripe = static_cast<std::uint8_t>(std::lround(mesh.positions[v].x * 8) % 2 == 0 ? 60 : 200);
            mesh.corner_colours.push_back({stripe, 60, 60, 255});
        }
    LayerInput in = b.input();
    in.fitted = true;
    in.texture_size = {16, 16};
    const StoredPositions positions = store_positions(in);
    const model::Layer sampled = *make_texture(in),
                       fitted = *make_texture(in, match_source(in, positions, 4 * 16 * 16));
    const auto others = match_source(in, positions, 5'003);
    EXPECT_LT(colour_error(in, others, fitted), 0.9 * colour_error(in, others, sampled));
    const auto rgba = read<std::uint8_t>(fitted);
    for (std::size_t t = 0; t < rgba.size(); t += 4) {
        EXPECT_GE(rgba[t], 60);
        EXPECT_LE(rgba[t], 200);
        EXPECT_EQ(rgba[t + 1], 60);
        EXPECT_EQ(rgba[t + 3], 255);
    }
}

TEST(GridLeastSquares, FindsTheValuesThatRowsWereMadeOf) {
    // Chains of taps over nine unknowns, the last in no row, one row with a tap twice.
    const std::array<double, 8> truth{3, -1, 4, 1, -5, 9, 2, -6};
    std::vector<GridRow<2>> rows;
    for (std::uint32_t k = 0; k < 16; ++k) {
        GridRow<2> row;
        row.unknown = {k % 8, (k + 1 + k / 8) % 8, (k + 3) % 8, k == 5 ? k : (k + 6) % 8};
        row.w = {0.5, 0.3, k % 3 == 0 ? 0.0 : 0.25, -0.05};
        row.weight = 1 + k % 4;
        for (std::size_t c = 0; c < 4; ++c) row.value[0] += row.w[c] * truth[row.unknown[c]];
        row.value[1] = 2 * row.value[0];
        rows.push_back(row);
    }
    const auto x = grid_least_squares<2>(rows, 9, 0, 100);
    for (std::size_t u = 0; u < 8; ++u) {
        EXPECT_NEAR(x[u][0], truth[u], 1e-2) << u;
        EXPECT_NEAR(x[u][1], 2 * truth[u], 2e-2) << u;
    }
    EXPECT_EQ(x[8][0], 0);
}

}  // namespace
}  // namespace dgm::bake
