// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/geometry/parameterize/slim_test.cpp
#include "geometry/parameterize/slim.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstring>

#include "disks.h"
#include "geometry/metrics/map_metrics.h"

namespace dgm::bake {
namespace {
using testing::Disk;
const model::Progress kSilent;

Disk hill(std::uint32_t n) {
    Disk d = testing::grid(n, n, [](double s, double t) {
        return Vec3d{s, t, 0.8 * std::exp(-20 * ((s - 0.4) * (s - 0.4) + (t - 0.55) * (t - 0.55)))};
    });
    testing::put_grid_border_on_square(d, n, n);
    return d;
}

/// The hill's own (s, t), with the interior moved off its place in a way that flips nothing.
std::vector<Vec2d> skewed(std::uint32_t n) {
    std::vector<Vec2d> uv;
    for (std::uint32_t i = 0; i <= n; ++i)
        for (std::uint32_t j = 0; j <= n; ++j) {
            const double s = static_cast<double>(j) / n, t = static_cast<double>(i) / n;
            const double b = s * (1 - s) * t * (1 - t);
            uv.push_back({s + 0.9 * b * t, t - 1.1 * b * s});
        }
    return uv;
}

class SlimEnergies : public ::testing::TestWithParam<FlipFreeEnergy> {};
INSTANTIATE_TEST_SUITE_P(All, SlimEnergies,
                         ::testing::Values(FlipFreeEnergy::kSymmetricDirichlet, FlipFreeEnergy::kArap,
                                           FlipFreeEnergy::kStretch));

TEST_P(SlimEnergies, GradientAgreesWithFiniteDifferences) {
    const Disk d = hill(5);
    // With a free border the rest shapes do not depend on the map, so neither does their scale.
    const SlimOptions options{.energy = GetParam(), .stretch_epsilon = 0.05};
    std::vector<Vec2d> uv = skewed(5), gradient;
    ASSERT_EQ(count_not_positive(d.faces, uv), 0U);
    static_cast<void>(flip_free_energy(d.view(), uv, options, &gradient));
    const double h = 1e-6;
    for (std::size_t v = 0; v < uv.size(); ++v)
        for (const bool in_x : {true, false}) {
            double& c = in_x ? uv[v].x : uv[v].y;
            const double at = c;
            c = at + h;
            const double above = flip_free_energy(d.view(), uv, options);
            c = at - h;
            const double below = flip_free_energy(d.view(), uv, options);
            c = at;
            EXPECT_NEAR(in_x ? gradient[v].x : gradient[v].y, (above - below) / (2 * h), 2e-7) << "vertex " << v;
        }
}

TEST_P(SlimEnergies, DoNotSeeHowRestShapesLieInTheirPlane) {
    const Disk d = hill(5);
    SlimOptions options{.energy = GetParam(), .stretch_epsilon = 0.05};
    const std::vector<RestShape> upright = rest_shapes(d.view());
    std::vector<RestShape> turned = upright;
    for (std::size_t f = 0; f < turned.size(); ++f) {
        const double angle = 0.7 * static_cast<double>(f), c = std::cos(angle), s = std::sin(angle);
        for (Vec2d& h : turned[f].hat) h = {c * h.x - s * h.y, s * h.x + c * h.y};
    }
    std::vector<Vec2d> gradient, other;
    options.rest = upright;
    const double energy = flip_free_energy(d.view(), skewed(5), options, &gradient);
    options.rest = turned;
    EXPECT_NEAR(flip_free_energy(d.view(), skewed(5), options, &other), energy, 1e-12 * energy);
    for (std::size_t v = 0; v < gradient.size(); ++v) {
        EXPECT_NEAR(other[v].x, gradient[v].x, 1e-10) << "vertex " << v;
        EXPECT_NEAR(other[v].y, gradient[v].y, 1e-10) << "vertex " << v;
    }
}

TEST_P(SlimEnergies, EnergyNeverRisesAndNothingFlips) {
    const Disk d = hill(12);
    SlimOptions options{.energy = GetParam(), .border_fixed = GetParam() == FlipFreeEnergy::kStretch, .tolerance = 0};
    double last = flip_free_energy(d.view(), skewed(12), options);
    const double start = last;
    for (std::size_t steps = 0; steps <= 8; ++steps) {
        options.iterations = steps;
        SlimReport report;
        const auto uv = descend_flip_free(d.view(), skewed(12), options, kSilent, &report);
        EXPECT_EQ(count_not_positive(d.faces, uv), 0U);
        const double energy = flip_free_energy(d.view(), uv, options);
        EXPECT_NEAR(energy, report.energy, 1e-12 * energy);
        EXPECT_LE(energy, last * (1 + 1e-14)) << steps;
        last = energy;
    }
    EXPECT_LT(last, 0.99 * start);
}

TEST(Slim, EnergyOfAKnownStretchedSquare) {
    // One unit square of two faces, drawn twice as wide and half as high: s1 = 2, s2 = 1/2 in both faces.
    const Disk d = testing::grid(1, 1, [](double s, double t) { return Vec3d{s, t, 0}; });
    const std::vector<Vec2d> uv{{0, 0}, {2, 0}, {0, 0.5}, {2, 0.5}};
    EXPECT_NEAR(flip_free_energy(d.view(), uv, {.energy = FlipFreeEnergy::kSymmetricDirichlet}), 4.25, 1e-14);
    // (2-1)^2 + (1/2-1)^2 + 0.01 ((1/2-1)^2 + (2-1)^2)
    EXPECT_NEAR(flip_free_energy(d.view(), uv, {.energy = FlipFreeEnergy::kArap, .barrier = 0.01}), 1.2625, 1e-14);
    // 4.25 + 0.1 * 4.25
    EXPECT_NEAR(flip_free_energy(d.view(), uv, {.energy = FlipFreeEnergy::kStretch, .stretch_epsilon = 0.1}), 4.675,
                1e-14);
    const std::vector<Vec2d> flipped{{0, 0}, {-2, 0}, {0, 0.5}, {-2, 0.5}};
    EXPECT_TRUE(std::isinf(flip_free_energy(d.view(), flipped, {})));
}

TEST(Slim, SmallPowersOfTheStretch) {
    // As above: s1 = 2, s2 = 1/2; 2^-1/2 + 2^1/2 + 0.1 * 4.25.
    const Disk square = testing::grid(1, 1, [](double s, double t) { return Vec3d{s, t, 0}; });
    const std::vector<Vec2d> uv{{0, 0}, {2, 0}, {0, 0.5}, {2, 0.5}};
    const SlimOptions options{
        .energy = FlipFreeEnergy::kStretch, .tolerance = 0, .stretch_epsilon = 0.1, .stretch_power = 0.5};
    EXPECT_NEAR(flip_free_energy(square.view(), uv, options), 1.5 * std::numbers::sqrt2 + 0.425, 1e-14);
    // Where the two stretches are equal the divided difference of the slopes is a 0/0: steps must still be Newton's.
    const Disk d = hill(12);
    SlimOptions fixed = options;
    fixed.border_fixed = true;
    fixed.iterations = 300;
    SlimReport report;
    const auto lowered = descend_flip_free(d.view(), skewed(12), fixed, kSilent, &report);
    EXPECT_LT(report.energy, report.start_energy);
    std::vector<Vec2d> gradient;
    static_cast<void>(flip_free_energy(d.view(), lowered, fixed, &gradient));
    for (std::size_t v = 0; v < gradient.size(); ++v)
        if (std::find(d.border.begin(), d.border.end(), v) == d.border.end()) {
            EXPECT_LT(length(gradient[v]), 1e-7) << v;
        }
}

TEST(Slim, ASpreadStartIsFreeOfFlips) {
    for (const Disk& d : {testing::sphere_with_hole(24, 30, 0.02), testing::long_finger(8, 150), hill(12)}) {
        const auto start = flip_free_start(d.view(), kSilent, FlipFreeStart::kSpread);
        ASSERT_TRUE(start.has_value());
        EXPECT_EQ(count_not_positive(d.faces, *start), 0U);
    }
}

TEST(Slim, FlattensADevelopablePatchExactly) {
    // A quarter of a cylinder of radius 1/2: isometric to a rectangle, energy 2.
    const Disk d = testing::grid(6, 8, [](double s, double t) {
        const double angle = 0.5 * std::numbers::pi * s;
        return Vec3d{0.5 * std::sin(angle), 0.3 * t, 0.5 * std::cos(angle)};
    });
    const auto start = flip_free_start(d.view(), kSilent);
    ASSERT_TRUE(start.has_value());
    SlimReport report;
    const auto uv = descend_flip_free(d.view(), *start, {.iterations = 100, .tolerance = 1e-14}, kSilent, &report);
    EXPECT_GT(report.start_energy, 2.1);
    // A strip of chords is flat: each row of quads is planar, so the polyhedral patch unrolls without distortion.
    EXPECT_NEAR(report.energy, 2, 1e-9);
    EXPECT_LE(report.factorizations, report.iterations + 1);  // the last step may find nothing lower
    const double chord = 2 * 0.5 * std::sin(0.5 * std::numbers::pi / 16);
    EXPECT_NEAR(length(uv[1] - uv[0]), chord, 1e-5);
    EXPECT_NEAR(length(uv[6 * 9 + 8] - uv[0]), std::hypot(8 * chord, 0.3), 1e-5);
}

TEST(Slim, StretchDescentKeepsTheBorderToTheBitAndLowersTheMeasuredStretch) {
    const Disk d = hill(16);
    const std::vector<Vec2d> start = skewed(16);
    const auto uv =
        descend_flip_free(d.view(), start, {.energy = FlipFreeEnergy::kStretch, .border_fixed = true}, kSilent);
    for (const std::uint32_t v : d.border) EXPECT_EQ(std::memcmp(&uv[v], &start[v], sizeof(Vec2d)), 0);
    const double before = measure_map(d.positions, d.faces, start).stretch_l2;
    const double after = measure_map(d.positions, d.faces, uv).stretch_l2;
    EXPECT_LT(after, 0.9 * before);
}

TEST(Slim, NastyDisksStartAndStayFreeOfFlips) {
    const Disk disks[] = {testing::sphere_with_hole(24, 30, 0.02), testing::long_finger(8, 150)};
    for (const Disk& d : disks) {
        const auto start = flip_free_start(d.view(), kSilent);
        ASSERT_TRUE(start.has_value());
        EXPECT_EQ(count_not_positive(d.faces, *start), 0U);
        SlimReport report;
        const auto uv = descend_flip_free(d.view(), *start, {.iterations = 100}, kSilent, &report);
        EXPECT_EQ(measure_map(d.positions, d.faces, uv).flips, 0U);
        EXPECT_EQ(measure_map(d.positions, d.faces, uv).degenerate, 0U);
        EXPECT_LT(report.energy, 0.1 * report.start_energy);
    }
}

TEST(Slim, SmallestDisks) {
    // A regular tetrahedron without its base: by symmetry the tip belongs in the middle of the border.
    const double h = std::sqrt(3.0) / 2;
    const Disk tip{{{0, 0, 0}, {1, 0, 0}, {0.5, h, 0}, {0.5, h / 3, std::sqrt(2.0 / 3)}},
                   {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}},
                   {0, 1, 2},
                   {}};
    const std::vector<Vec2d> off{{0, 0}, {1, 0}, {0.5, h}, {0.3, 0.2}};
    const SlimOptions fixed{.border_fixed = true, .tolerance = 1e-14};
    const auto uv = descend_flip_free(tip.view(), off, fixed, kSilent);
    EXPECT_NEAR(uv[3].x, 0.5, 1e-6);
    EXPECT_NEAR(uv[3].y, h / 3, 1e-6);

    const Disk triangle{{{0, 0, 0}, {1, 0, 0}, {0.5, h, 0}}, {{0, 1, 2}}, {0, 1, 2}, {}};
    const std::vector<Vec2d> squeezed{{0, 0}, {3, 0}, {1, 0.2}};
    SlimReport report;
    static_cast<void>(descend_flip_free(triangle.view(), squeezed, {.tolerance = 1e-14}, kSilent, &report));
    EXPECT_NEAR(report.energy, 2, 1e-9);
    // Nothing to move.
    EXPECT_EQ(descend_flip_free(triangle.view(), squeezed, fixed, kSilent), squeezed);
}

TEST(Slim, IsDeterministic) {
    const Disk d = testing::sphere_with_hole(12, 12, 0.1);
    const auto a = descend_flip_free(d.view(), flip_free_start(d.view(), kSilent).value(), {}, kSilent);
    const auto b = descend_flip_free(d.view(), flip_free_start(d.view(), kSilent).value(), {}, kSilent);
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec2d)), 0);
}

TEST(Slim, RefusesStartsThatAreNoMap) {
    const Disk d = hill(4);
    std::vector<Vec2d> uv = skewed(4);
    EXPECT_THROW(static_cast<void>(descend_flip_free(d.view(), {}, {}, kSilent)), model::Error);
    std::swap(uv[6], uv[7]);
    EXPECT_THROW(static_cast<void>(descend_flip_free(d.view(), uv, {}, kSilent)), model::Error);
    uv = skewed(4);
    uv[12].x = std::nan("");
    EXPECT_THROW(static_cast<void>(descend_flip_free(d.view(), uv, {}, kSilent)), model::Error);
}

TEST(Slim, StopsWhenAsked) {
    const Disk d = hill(4);
    std::atomic<bool> stop{true};
    const model::Progress progress{.on_update = {}, .cancelled = &stop};
    try {
        static_cast<void>(descend_flip_free(d.view(), skewed(4), {}, progress));
        FAIL() << "not interrupted";
    } catch (const model::Error& e) { EXPECT_EQ(e.code().number, model::codes::kInterrupted.number); }
}
}  // namespace
}  // namespace dgm::bake
