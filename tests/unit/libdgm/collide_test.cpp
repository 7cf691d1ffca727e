// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/collide_test.cpp
// Nearest sample against exhaustive search, tracking, hit test, force.
#include <gtest/gtest.h>

#include <dgm/collide.h>
#include <dgm/deform.h>
#include <dgm/force.h>

#include <cmath>
#include <limits>
#include <random>

#include "opened.h"

namespace dgm::test {
namespace {

Nearest exhaustive(const State& state, Vec3 tool) {
    const PointView p = state.positions();
    float best = std::numeric_limits<float>::infinity();
    std::uint32_t sample = kNone;
    for (std::uint32_t k = 0; k < p.count; ++k) {
        if (!state.on_surface(k)) continue;
        const Vec3 d = p[k] - tool;
        const float d2 = dot(d, d);
        if (d2 < best) {
            best = d2;
            sample = k;
        }
    }
    return {sample, std::sqrt(best)};
}

/// A closed tube with folds: near sheets that are far apart along the surface.
Point wavy_tube(double i, double j) {
    const double a = 2 * 3.14159265358979 * j / 40, r = 3 + 2.5 * std::sin(3 * a) * std::cos(i / 4);
    return {static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)), static_cast<float>(i / 5)};
}

void compare(State& state, int count, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> x(-7, 7), z(-2, 10);
    for (int k = 0; k < count; ++k) {
        const Vec3 tool{x(random), x(random), z(random)};
        const auto found = nearest_sample(state, tool);
        ASSERT_TRUE(found.ok());
        const Nearest want = exhaustive(state, tool);
        ASSERT_EQ(found.value().sample, want.sample);
        ASSERT_EQ(found.value().distance, want.distance);
    }
}

TEST(Nearest, EqualsExhaustiveSearch) {
    State state = make_state(grid_chart(43, 41, wavy_tube, tube_seams(43, 41)));
    compare(state, 100000, 1);
}

TEST(Nearest, AfterTouchesReleaseAndReset) {
    State state = make_state(grid_chart(43, 41, wavy_tube, tube_seams(43, 41)));
    KernelOptions kernel;
    kernel.reach = 9;
    const DeformTable table = DeformTable::create(kernel).value();
    std::mt19937 random(2);
    for (int round = 0; round < 60; ++round) {
        Touch touch;
        touch.sample = random() % (43 * 41);
        touch.displacement = {float(random() % 7) - 3, float(random() % 7) - 3, float(random() % 7) - 3};
        touch.d_max = 3;
        touch.mode = round % 4 == 0 ? DeformMode::Plastic : DeformMode::Elastic;
        ASSERT_TRUE(deform(state, table, touch).ok());
        if (round % 3 == 0) compare(state, 200, 100 + round);
        if (round % 7 == 0) state.release();
        if (round % 7 == 0) compare(state, 200, 200 + round);
        if (round == 40) state.reset();
    }
}

TEST(Nearest, FreeDomainWithBorderSamples) {
    ChartSpec c = free_chart(30, 21, wavy_tube);
    State state = make_state(c);
    compare(state, 20000, 3);
}

TEST(Nearest, SmallGridsAndTies) {
    State state = make_state(grid_chart(2, 2, [](double i, double j) { return Point{float(i), float(j), 0}; }));
    EXPECT_EQ(nearest_sample(state, {0.5f, 0.5f, 0}).value().sample, 0u);
    EXPECT_EQ(nearest_sample(state, {0.9f, 0.5f, 0}).value().sample, 2u);
    EXPECT_NEAR(nearest_sample(state, {1, 1, 2}).value().distance, 2, 1e-7);
    // 9 and 10 samples: the last row belongs to the first tile, and to a second one.
    for (const std::uint32_t side : {9u, 10u, 17u, 18u}) {
        State edge = make_state(grid_chart(side, side, sheet));
        EXPECT_EQ(nearest_sample(edge, {100, 100, 0}).value().sample, side * side - 1);
    }
}

TEST(Nearest, NothingToFindAndBadTools) {
    ChartSpec c = grid_chart(9, 9, sheet);
    c.domain = layout::Domain::kFree;
    c.add("mask", ElementType::kU8, {9, 9}, std::vector<std::uint8_t>(81, 0));
    State state = make_state(c);
    EXPECT_EQ(nearest_sample(state, {0, 0, 0}).error().code, ErrorCode::NotFound);
    EXPECT_EQ(track_sample(state, {0, 0, 0}, 5, 2).error().code, ErrorCode::BadArgument);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(nearest_sample(state, {0, nan, 0}).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(nearest_sample(state, {INFINITY, 0, 0}).error().code, ErrorCode::BadArgument);
}

TEST(Track, FollowsThePathAcrossTheSeam) {
    const auto tube = [](double i, double j) {
        const double a = 2 * 3.14159265358979 * j / 40;
        return Point{static_cast<float>(3 * std::cos(a)), static_cast<float>(3 * std::sin(a)),
                     static_cast<float>(i / 3)};
    };
    State state = make_state(grid_chart(31, 41, tube, tube_seams(31, 41)));
    const auto tool_at = [](double turn) {
        return Vec3{static_cast<float>(3.2 * std::cos(turn)), static_cast<float>(3.2 * std::sin(turn)), 5.02f};
    };
    std::uint32_t last = nearest_sample(state, tool_at(1)).value().sample;
    for (double turn = 1; turn < 1 + 4 * 3.14159; turn += 0.05) {
        const auto found = track_sample(state, tool_at(turn), last, 2);
        ASSERT_TRUE(found.ok());
        ASSERT_EQ(found.value().sample, exhaustive(state, tool_at(turn)).sample) << turn;
        last = found.value().sample;
    }
    // The window is 2a + 1 wide: at a = 1 a tool three columns on is found only as far as the window goes.
    const auto p = state.positions();
    EXPECT_EQ(track_sample(state, p[15 * 41 + 13], 15 * 41 + 10, 1).value().sample, 15u * 41 + 11);
    EXPECT_EQ(track_sample(state, p[15 * 41 + 13], 15 * 41 + 10, 3).value().sample, 15u * 41 + 13);
    EXPECT_EQ(track_sample(state, p[15 * 41 + 38], 15 * 41 + 1, 2).value().sample, 15u * 41 + 39);
    EXPECT_EQ(track_sample(state, p[0], 0, 65).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(track_sample(state, {NAN, 0, 0}, 0, 1).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(track_sample(state, p[0], 31 * 41, 1).error().code, ErrorCode::BadArgument);
}

TEST(Hit, SignOfTheProduct) {
    EXPECT_TRUE(hit_test({0, 0, -1}, {0, 0, 1}).value());
    EXPECT_FALSE(hit_test({0, 0, 1}, {0, 0, 1}).value());
    EXPECT_FALSE(hit_test({1, 0, 0}, {0, 0, 1}).value());
    EXPECT_TRUE(hit_test({1e30f, 0, -1e30f}, {0.6f, 0, 0.8f}).value());
    EXPECT_TRUE(hit_test({-1e-40f, 0, 0}, {1e-20f, 0, 0}).value());  // the product vanishes in float
    EXPECT_EQ(hit_test({NAN, 0, 0}, {0, 0, 1}).error().code, ErrorCode::BadArgument);
}

TEST(Hit, NormalOfTheSurface) {
    // A sheet z = 0 with i along x and j along y: counter-clockwise in (u, v) looks along +z.
    State state = make_state(grid_chart(5, 5, [](double i, double j) { return Point{float(i), float(j), 0}; }));
    for (std::uint32_t k = 0; k < 25; ++k) EXPECT_EQ(state.normal(k), (Vec3{0, 0, 1}));
    EXPECT_EQ(state.normal(25), (Vec3{0, 0, 0}));
    // A tilted plane z = 2x: normal (-2, 0, 1) / sqrt(5).
    State tilted = make_state(grid_chart(5, 5, [](double i, double j) {
        return Point{float(i), float(j), float(2 * i)};
    }));
    EXPECT_NEAR(tilted.normal(12).x, -0.89442719f, 1e-6);
    EXPECT_NEAR(tilted.normal(12).z, 0.44721360f, 1e-6);
}

TEST(Hit, NormalsOfCopiesAreEqualAndSeeBothSides) {
    State state = make_state(grid_chart(
        9, 41,
        [](double i, double j) {
            const double a = 2 * 3.14159265358979 * j / 40;
            return Point{float(std::cos(a)), float(std::sin(a)), float(-i)};
        },
        tube_seams(9, 41)));
    for (std::uint32_t i = 0; i < 9; ++i) {
        const Vec3 a = state.normal(i * 41), b = state.normal(i * 41 + 40);
        EXPECT_TRUE(same_bits(a, b));
        EXPECT_NEAR(std::fabs(a.x), 1, 4e-3);  // one-sided it would be off by half a step, 0.079 in y
        EXPECT_NEAR(a.y, 0, i == 0 || i == 8 ? 0.03 : 1e-6);
    }
}

TEST(Force, CubeOfTheShareOfDMax) {
    const Vec3 f = contact_force({0.5f, -1, 2}, 2, 8).value();
    EXPECT_NEAR(f.x, -0.125f, 1e-7);  // -(1/4)^3 * 8
    EXPECT_NEAR(f.y, 1, 1e-7);        // (1/2)^3 * 8
    EXPECT_EQ(f.z, -8.0f);
    EXPECT_EQ(contact_force({1e30f, -1e30f, 0}, 2, 8).value(), (Vec3{-8, 8, 0}));
    EXPECT_EQ(contact_force({0, 0, 0}, 0, 8).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(contact_force({0, NAN, 0}, 1, 8).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(contact_force({0, 0, 0}, 1, -1).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(contact_force({0, 0, 0}, INFINITY, 1).error().code, ErrorCode::BadArgument);
}

}  // namespace
}  // namespace dgm::test
