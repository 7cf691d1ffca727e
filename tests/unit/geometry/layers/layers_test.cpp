// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/layers/layers_test.cpp
// Layers of charts that are laid by hand on planes, cylinders and balls, so that every value is known.
#include "geometry/layers/layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "layer_bench.h"
#include "model/half.h"
#include "model/octahedral.h"
#include "support/meshes.h"

namespace dgm::bake {
namespace {
constexpr double kPi = std::numbers::pi;

Vec3d source_position(const Bench& b, std::size_t s) {
    return b.frame.centre + b.chart.positions[s] * b.frame.diagonal;
}
Vec3d decoded_position(const Bench& b, const Vec3d& stored) {
    Vec3d p;
    for (int k = 0; k < 3; ++k) p[k] = b.stored.offset[k] + b.stored.scale[k] * stored[k];
    return p;
}

/// One chart of an asset whose other charts make it 1e6 times as wide: about its own centre it loses nothing to floats.
TEST(GeometryLayer, F32OfATinyChartFarFromTheOriginIsStoredAboutItsOwnCentre) {
    const auto at = [](double size) {
        Bench b = patch(5, 7, [&](double x, double y) { return Vec3d{0.4 + size * x, 0.3 + size * y, -0.2}; });
        b.frame = {{0, 0, 0}, 1};
        b.stored = choose_frame(b.frame, b.chart, false);
        return b;
    };
    EXPECT_EQ(at(0.01).stored.offset, (std::array<double, 3>{0, 0, 0})) << "parts of ordinary assets stay as they are";
    const Bench b = at(1e-6);
    EXPECT_NEAR(b.stored.offset[0], 0.4 + 0.5e-6, 1e-12);
    const StoredPositions out = store_positions(b.input());
    for (std::size_t s = 0; s < b.chart.grid_count(); ++s)
        EXPECT_LT(length(decoded_position(b, out.local[s]) - source_position(b, s)), 1e-13);
}

TEST(GeometryLayer, F32RoundsOnceAndMovesFarAssetsToTheirCentre) {
    for (const double far : {0.0, 10.0, 1e7}) {
        const Bench b = baked(test::icosphere(3, 3), 17, 13, false, {far, -far, far});
        EXPECT_EQ(b.stored.scale, (std::array<double, 3>{1, 1, 1}));
        EXPECT_EQ(b.stored.offset[0] != 0, far > 1000);
        const StoredPositions out = store_positions(b.input());
        EXPECT_EQ(out.geometry.type, model::ElementType::kF32);
        EXPECT_EQ(out.geometry.shape, (std::vector<std::uint64_t>{17, 13, 3}));
        EXPECT_EQ(out.worst_quantisation, 0);
        EXPECT_FALSE(out.border_geometry);
        const std::vector<float> values = read<float>(out.geometry);
        for (std::size_t s = 0; s < b.chart.grid_count(); ++s) {
            const Vec3d stored{values[3 * s], values[3 * s + 1], values[3 * s + 2]};
            EXPECT_EQ(out.local[s], stored);
            const Vec3d want = source_position(b, s);
            for (int k = 0; k < 3; ++k) {
                // Half an ulp of a float that is at most 14, and the rounding of the source's own doubles.
                ASSERT_NEAR(decoded_position(b, stored)[k], want[k], 14 * 0x1p-24 + std::abs(far) * 0x1p-51);
            }
        }
    }
}

TEST(GeometryLayer, U16ErrsByHalfAStepAtMost) {
    for (const TriMesh& mesh : {test::icosphere(3, 3), test::torus(3, 1, 30, 16)}) {
        const Bench b = baked(mesh, 21, 17, true);
        const StoredPositions out = store_positions(b.input());
        EXPECT_EQ(out.geometry.type, model::ElementType::kU16);
        const std::vector<std::uint16_t> values = read<std::uint16_t>(out.geometry);
        Vec3d lo{1e9, 1e9, 1e9}, hi{-1e9, -1e9, -1e9};
        for (std::size_t s = 0; s < b.chart.grid_count(); ++s)
            for (int k = 0; k < 3; ++k) {
                lo[k] = std::min(lo[k], source_position(b, s)[k]);
                hi[k] = std::max(hi[k], source_position(b, s)[k]);
            }
        const double step = std::max({hi.x - lo.x, hi.y - lo.y, hi.z - lo.z}) / 65535;
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(b.stored.scale[k], step, 1e-12 * step) << "one step for all axes";
            EXPECT_NEAR(b.stored.offset[k], lo[k], 1e-12);
        }
        EXPECT_NEAR(out.worst_quantisation, step / 2, 1e-12 * step);
        double worst = 0;
        for (std::size_t s = 0; s < b.chart.grid_count(); ++s) {
            const Vec3d stored{double(values[3 * s]), double(values[3 * s + 1]), double(values[3 * s + 2])};
            const Vec3d got = decoded_position(b, stored), want = source_position(b, s);
            for (int k = 0; k < 3; ++k) {
                worst = std::max(worst, std::abs(got[k] - want[k]));
                EXPECT_NEAR(out.local[s][k], b.stored.scale[k] * stored[k], 1e-15);
            }
            const std::uint32_t rep = b.chart.representative[s];
            for (int k = 0; k < 3; ++k)
                ASSERT_EQ(values[3 * s + k], values[3 * rep + k]) << "copies are equal to the bit";
        }
        EXPECT_LE(worst, step / 2 * (1 + 1e-9));
        EXPECT_GT(worst, step / 4) << "the step is not finer than it says";
    }
}

TEST(NormalLayer, UnitAndRadialOnABall) {
    const Bench b = baked(test::icosphere(4, 3), 25, 21, false);
    const StoredNormals out = store_normals(b.input());
    EXPECT_EQ(out.normal.shape, (std::vector<std::uint64_t>{25, 21, 2}));
    const std::vector<std::int16_t> codes = read<std::int16_t>(out.normal);
    for (std::size_t s = 0; s < b.chart.grid_count(); ++s) {
        const Vec3d n = model::decode_octahedral({codes[2 * s], codes[2 * s + 1]});
        EXPECT_EQ(out.decoded[s], n);
        ASSERT_NEAR(length(n), 1, 1e-6);
        const Vec3d radial = normalized(source_position(b, s) - Vec3d{10, 20, 30});
        ASSERT_GT(dot(n, radial), std::cos(0.5 * kPi / 180)) << s / 21 << ", " << s % 21;
        const std::uint32_t rep = b.chart.representative[s];
        ASSERT_EQ(codes[2 * s], codes[2 * rep]);
        ASSERT_EQ(codes[2 * s + 1], codes[2 * rep + 1]);
    }
}

TEST(NormalLayer, TheSourcesOwnNormalsWin) {
    Bench b = patch(5, 5, [](double x, double y) { return Vec3d{x, y, 0}; });
    const Vec3d own = normalized(Vec3d{1, 2, 3});
    b.chart.disk.own().mesh.corner_normals.assign(3 * b.chart.disk->mesh.faces.size(), own);
    for (const Vec3d& n : store_normals(b.input()).decoded) EXPECT_LT(length(n - own), 1e-4);
    b.chart.disk.own().mesh.corner_normals.assign(3 * b.chart.disk->mesh.faces.size(), Vec3d{});  // "none"
    for (const Vec3d& n : store_normals(b.input()).decoded) EXPECT_LT(length(n - Vec3d{0, 0, 1}), 1e-4);
}

struct Boxes {
    std::vector<std::uint32_t> levels;
    std::vector<float> values;
    [[nodiscard]] bool holds(std::size_t box, const Vec3d& p) const {
        for (int k = 0; k < 3; ++k)
            if (p[k] < values[6 * box + k] || p[k] > values[6 * box + 3 + k]) return false;
        return true;
    }
};

TEST(CollisionLayer, BoxesHoldTheirTilesAndTheirChildren) {
    for (const auto& [m, n] : {std::pair{17u, 33u}, {9u, 9u}, {10u, 42u}, {3u, 3u}}) {
        const Bench b = baked(test::torus(3, 1, 30, 16), std::max(m, 9u), std::max(n, 9u), false);
        const std::uint32_t rows = b.chart.m, cols = b.chart.n;
        const std::vector<Vec3d> local = store_positions(b.input()).local;
        const model::Layer layer = make_collision(b.chart, local);
        const Boxes boxes{std::get<std::vector<std::uint32_t>>(layer.attributes.at("levels")), read<float>(layer)};
        // Levels: ceil(quads / 8) tiles, then halved, rounded up, down to one root.
        std::vector<std::uint32_t> want;
        std::uint32_t r = (rows - 1 + 7) / 8, c = (cols - 1 + 7) / 8;
        std::size_t nodes = 0;
        while (true) {
            want.push_back(r);
            want.push_back(c);
            nodes += std::size_t{r} * c;
            if (r == 1 && c == 1) break;
            r = (r + 1) / 2;
            c = (c + 1) / 2;
        }
        EXPECT_EQ(boxes.levels, want);
        ASSERT_EQ(layer.shape, (std::vector<std::uint64_t>{nodes, 6}));
        for (std::uint32_t i = 0; i + 1 < rows; ++i)
            for (std::uint32_t j = 0; j + 1 < cols; ++j)
                for (std::uint32_t k = 0; k < 4; ++k) {
                    const Vec3d& p = local[(i + k / 2) * cols + j + k % 2];
                    std::size_t first = 0;
                    for (std::size_t level = 0; 2 * level < want.size(); ++level) {
                        const std::uint32_t row = i / 8 >> level, col = j / 8 >> level;
                        ASSERT_TRUE(boxes.holds(first + std::size_t{row} * want[2 * level + 1] + col, p));
                        first += std::size_t{want[2 * level]} * want[2 * level + 1];
                    }
                }
        // Tight: the root is the bounding box, up to a float's rounding.
        Vec3d lo{1e9, 1e9, 1e9}, hi{-1e9, -1e9, -1e9};
        for (const Vec3d& p : local)
            for (int k = 0; k < 3; ++k) {
                lo[k] = std::min(lo[k], p[k]);
                hi[k] = std::max(hi[k], p[k]);
            }
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(boxes.values[6 * (nodes - 1) + k], lo[k], 1e-5);
            EXPECT_NEAR(boxes.values[6 * (nodes - 1) + 3 + k], hi[k], 1e-5);
        }
    }
}

TEST(CoverLayer, NoPointOfItsQuadsIsFarther) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> u(0, 1);
    const Bench b = baked(test::icosphere(3, 3), 17, 13, false);
    const std::vector<Vec3d> local = store_positions(b.input()).local;
    const std::vector<float> radius = read<float>(make_cover(b.chart, local));
    ASSERT_EQ(radius.size(), 17u * 13u);
    std::vector<double> farthest(radius.size(), 0.0);
    for (const Face& f : b.chart.faces())
        for (int round = 0; round < 30; ++round) {
            double x = u(random), y = u(random);
            if (x + y > 1) {
                x = 1 - x;
                y = 1 - y;
            }
            const Vec3d p = local[f[0]] * (1 - x - y) + local[f[1]] * x + local[f[2]] * y;
            for (std::uint32_t s : f) {
                const std::uint32_t rep = b.chart.representative[s];
                farthest[rep] = std::max(farthest[rep], length(p - local[s]));
            }
        }
    for (std::size_t s = 0; s < radius.size(); ++s) {
        EXPECT_GE(radius[s], farthest[b.chart.representative[s]]) << "sample " << s;
        EXPECT_EQ(radius[s], radius[b.chart.representative[s]]);
    }
}

TEST(CoverLayer, SquareCellsByHand) {
    Bench b = patch(5, 4, [](double x, double y) { return Vec3d{4 * 3 * x, 3 * 4 * y, 0}; });  // cells of 3 x 4
    const std::vector<Vec3d> local = store_positions(b.input()).local;
    for (float r : read<float>(make_cover(b.chart, local))) EXPECT_NEAR(r, 5, 1e-5);
}

TEST(DeformationLayer, FirstFundamentalFormOfAShearedPlane) {
    // One row step is (2, 1, 0), one column step (0.5, 3, 0).
    const Bench b = patch(6, 8, [](double x, double y) {
        const double i = 5 * x, j = 7 * y;
        return Vec3d{2 * i + 0.5 * j, i + 3 * j, 0};
    });
    const std::vector<float> values = read<float>(make_deformation(b.chart, store_positions(b.input()).local));
    for (std::size_t s = 0; s < 48; ++s) {
        EXPECT_NEAR(values[4 * s], 5, 1e-4);
        EXPECT_NEAR(values[4 * s + 1], 4, 1e-4);
        EXPECT_NEAR(values[4 * s + 2], 9.25, 1e-4);
        EXPECT_EQ(values[4 * s + 3], 1);
    }
}

/// A cylinder of radius 2, rows around it and joined to themselves: central differences of a circle are
/// 2 sin(step) long, across the seam too.
TEST(DeformationLayer, CylinderAcrossItsSeam) {
    const std::uint32_t m = 13, n = 6;
    const double step = 2 * kPi / (m - 1), height = 0.5;
    Bench b = patch(m, n, [&](double x, double y) {
        return Vec3d{2 * std::cos(2 * kPi * x), 2 * std::sin(2 * kPi * x), height * (n - 1) * y};
    });
    for (std::uint32_t j = 0; j < n; ++j) b.chart.representative[(m - 1) * n + j] = j;
    place_samples(b.chart);
    const std::vector<float> values = read<float>(make_deformation(b.chart, store_positions(b.input()).local));
    const double central = std::pow(2 * std::sin(step), 2);
    for (std::uint32_t i = 0; i < m; ++i)
        for (std::uint32_t j = 1; j + 1 < n; ++j) {
            EXPECT_NEAR(values[4 * (i * n + j)], central, 1e-5) << i << ", " << j;
            EXPECT_NEAR(values[4 * (i * n + j) + 1], 0, 1e-5);
            EXPECT_NEAR(values[4 * (i * n + j) + 2], height * height, 1e-5);
        }
}

TEST(DeformationLayer, StiffnessIsPaintedThroughAlpha) {
    Bench b = patch(5, 3, [](double x, double y) { return Vec3d{x, y, 0}; });
    auto& mesh = b.chart.disk.own().mesh;
    for (const Face& f : mesh.faces)
        for (std::uint32_t v : f) {
            const double x = mesh.positions[v].x;
            mesh.corner_colours.push_back({1, 2, 3, static_cast<std::uint8_t>(std::lround(200 * x))});
        }
    const std::vector<float> values = read<float>(make_deformation(b.chart, store_positions(b.input()).local));
    for (std::uint32_t i = 0; i < 5; ++i)
        for (std::uint32_t j = 0; j < 3; ++j) EXPECT_NEAR(values[4 * (i * 3 + j) + 3], 200 * (i / 4.0) / 255, 1e-6);
}

TEST(ContactLayer, AreasAddUpAndASquareIsShared) {
    const Bench flat = patch(3, 3, [](double x, double y) { return Vec3d{2 * x, 2 * y, 0}; });  // four cells of area 1
    const std::vector<float> shares = read<float>(make_contact(flat.chart, store_positions(flat.input()).local));
    double sum = 0;
    for (int s = 0; s < 9; ++s) {
        sum += shares[2 * s];
        EXPECT_EQ(shares[2 * s + 1], 1);
    }
    EXPECT_NEAR(sum, 4, 1e-6);
    int round_middle = 0;
    for (const Face& f : flat.chart.faces()) round_middle += std::count(f.begin(), f.end(), 4u) > 0;
    EXPECT_NEAR(shares[2 * 4], round_middle * 0.5 / 3, 1e-6) << "a third of each triangle of 1/2 that meets there";

    const Bench ball = baked(test::icosphere(4, 3), 33, 33, false);
    const std::vector<Vec3d> local = store_positions(ball.input()).local;
    const std::vector<float> areas = read<float>(make_contact(ball.chart, local));
    sum = 0;
    for (std::size_t s = 0; s < 33 * 33; ++s) sum += areas[2 * s];
    EXPECT_NEAR(sum, test::surface_area(local, ball.chart.faces()), 1e-4);
    EXPECT_NEAR(sum, 4 * kPi * 9, 0.03 * 4 * kPi * 9);
}

/// Between two samples a cylinder stands r (1 - cos(step / 2)) over the chord; along the axis it does not.
TEST(BumpLayer, SagittaOfACylinder) {
    const std::uint32_t m = 9, n = 5;
    const double r = 20, step = 0.5 * kPi / (m - 1);
    Bench b = patch(m, n, [&](double x, double y) {
        return Vec3d{r * std::cos(0.5 * kPi * x), r * std::sin(0.5 * kPi * x), 3 * y};
    });
    const StoredPositions positions = store_positions(b.input());
    const StoredNormals normals = store_normals(b.input());
    const model::Layer layer = make_bump(b.input(), positions, normals);
    EXPECT_EQ(layer.type, model::ElementType::kF16);
    ASSERT_EQ(layer.shape, (std::vector<std::uint64_t>{2 * m - 1, 2 * n - 1}));
    EXPECT_EQ(std::get<std::vector<double>>(layer.attributes.at("scale")), std::vector<double>{1});
    const std::vector<std::uint16_t> bits = read<std::uint16_t>(layer);
    const double sagitta = r * (1 - std::cos(step / 2));
    for (std::uint32_t i = 0; i < 2 * m - 1; ++i)
        for (std::uint32_t j = 0; j < 2 * n - 1; ++j) {
            const double h = model::half_value(bits[i * (2 * n - 1) + j]);
            if (i % 2 == 0 && j % 2 == 0) {
                EXPECT_EQ(h, 0);
            } else {
                EXPECT_NEAR(h, i % 2 == 0 ? 0 : sagitta, 0.03 * sagitta) << i << ", " << j;
            }
        }
}

TEST(BumpLayer, BallStandsOutBetweenSamples) {
    const Bench b = baked(test::icosphere(5, 3), 17, 17, false);
    const StoredPositions positions = store_positions(b.input());
    const std::vector<std::uint16_t> bits =
        read<std::uint16_t>(make_bump(b.input(), positions, store_normals(b.input())));
    int checked = 0;
    for (std::uint32_t i = 0; i < 16; ++i)
        for (std::uint32_t j = 2; j < 15; ++j) {
            const Vec3d p = positions.local[i * 17 + j], q = positions.local[(i + 1) * 17 + j];
            const double chord = length(p - q), sagitta = 3 - std::sqrt(9 - chord * chord / 4);
            const double h = model::half_value(bits[(2 * i + 1) * 33 + 2 * j]);
            // The map is not isometric, so the texel need not lie over the chord's middle; it lies over the chord.
            EXPECT_GT(h, 0.5 * sagitta - 0.003);
            EXPECT_LT(h, 1.1 * sagitta + 0.003);
            ++checked;
        }
    EXPECT_EQ(checked, 16 * 13);
}

TEST(BumpLayer, TinyAssetsKeepTheirRelief) {
    const double r = 1e-9;
    Bench b = patch(9, 5, [&](double x, double y) {
        return Vec3d{r * std::cos(0.5 * kPi * x), r * std::sin(0.5 * kPi * x), 0.2 * r * y};
    });
    b.frame.diagonal = 1;
    for (Vec3d& p : b.chart.disk.own().mesh.positions) p = p / 2e-9;
    b.frame.diagonal = 2e-9;
    place_samples(b.chart);
    const model::Layer layer = make_bump(b.input(), store_positions(b.input()), store_normals(b.input()));
    const double scale = std::get<std::vector<double>>(layer.attributes.at("scale")).at(0);
    const double sagitta = r * (1 - std::cos(kPi / 32));
    EXPECT_NEAR(scale * model::half_value(read<std::uint16_t>(layer)[9]), sagitta, 0.03 * sagitta);
}

}  // namespace
}  // namespace dgm::bake
