// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/tick_test.cpp
// Whole turns of the haptic loop: exact tracking, tools, forces without jumps, several contacts, refusals.
#include <gtest/gtest.h>

#include <dgm/collide.h>
#include <dgm/force.h>
#include <dgm/tick.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <random>

#include "asked.h"
#include "contact_shapes.h"
#include "opened.h"

namespace dgm::test {
namespace {
constexpr double kPi = std::numbers::pi;

Point flat(double i, double j) {
    return {static_cast<float>(i), static_cast<float>(j), 0};
}

DeformTable table_of(float sigma, std::uint32_t reach) {
    KernelOptions k;
    k.sigma = sigma;
    k.reach = reach;
    return DeformTable::create(k).value();
}

ToolInput tool_at(Vec3 position, ToolKind kind = ToolKind::Touch, std::uint32_t tool = 0) {
    ToolInput in;
    in.tool = tool;
    in.kind = kind;
    in.position = position;
    return in;
}

TickOptions options_of(float d_max, float f_max = 1, float settle = 0) {
    TickOptions o;
    o.d_max = d_max;
    o.f_max = f_max;
    o.settle_time = settle;
    o.footprint = Footprint::Grid;  // weights by eq. 7
    return o;
}

ToolOutput one(State& state, const DeformTable& table, const TickOptions& o, const ToolInput& in) {
    ToolOutput out;
    const auto done = tick(state, table, o, {&in, 1}, {&out, 1});
    EXPECT_TRUE(done.ok()) << done.error().message;
    return out;
}

TEST(Tick, TouchDisplacesTheContactAlongItsNormalByTheDepth) {
    State state = make_state(grid_chart(31, 31, flat));
    const DeformTable table = table_of(9, 6);
    // Nearest sample (12, 17), 0.5 below the sheet whose normal is +z; 0.2 beside the sample.
    const ToolOutput out = one(state, table, options_of(2, 8), tool_at({12.2f, 17, -0.5f}));
    EXPECT_EQ(out.sample, 12u * 31 + 17);
    EXPECT_NEAR(out.distance, std::hypot(0.2, 0.5), 1e-6);
    EXPECT_TRUE(out.hit);
    EXPECT_TRUE(out.holding);
    EXPECT_EQ(out.contact, out.sample);
    EXPECT_NEAR(out.displacement.x, 0, 1e-7);
    EXPECT_NEAR(out.displacement.z, -0.5, 1e-6);
    EXPECT_NEAR(out.force.z, 0.125, 1e-6);  // (0.5 / 2)^3 * 8, outwards
    for (int i = 0; i < 31; ++i)
        for (int j = 0; j < 31; ++j) {
            const int di = i - 12, dj = j - 17;
            const double want = std::abs(di) < 6 && std::abs(dj) < 6 ? -0.5 * std::exp(-(di * di + dj * dj) / 9.0) : 0;
            ASSERT_NEAR(state.positions().z[i * 31 + j], want, 1e-6);
            ASSERT_TRUE(same_bits(state.normals()[static_cast<std::size_t>(i * 31 + j)],
                                  state.normal(static_cast<std::uint32_t>(i * 31 + j))));
        }
    // Out again: the surface is at rest and there is no force.
    const ToolOutput away = one(state, table, options_of(2, 8), tool_at({12.2f, 17, 0.1f}));
    EXPECT_FALSE(away.hit);
    EXPECT_EQ(away.contact, kNone);
    EXPECT_EQ(away.force, (Vec3{0, 0, 0}));
    for (std::size_t k = 0; k < 31 * 31; ++k) ASSERT_TRUE(same_bits(state.positions()[k], state.rest_positions()[k]));
    // The paper's d runs from the sample to the tool.
    TickOptions printed = options_of(2, 8);
    printed.rule = ContactRule::Printed;
    EXPECT_NEAR(one(state, table, printed, tool_at({12.2f, 17, -0.5f})).displacement.x, 0.2, 1e-6);
}

TEST(Tick, DepthIsClampedToDMax) {
    State state = make_state(grid_chart(31, 31, flat));
    const ToolOutput out = one(state, table_of(9, 6), options_of(1.5f, 4), tool_at({12, 17, -20}));
    EXPECT_NEAR(out.displacement.z, -1.5, 1e-6);
    EXPECT_NEAR(out.force.z, 4, 1e-5);
    EXPECT_NEAR(state.positions().z[12 * 31 + 17], -1.5, 1e-6);
}

TEST(Tick, BesideAnOpenRimNothingIsTouched) {
    State state = make_state(grid_chart(31, 31, flat));
    EXPECT_FALSE(one(state, table_of(9, 6), options_of(2), tool_at({-5, 17, -3})).hit);
    EXPECT_TRUE(one(state, table_of(9, 6), options_of(2), tool_at({0.2f, 17, -0.3f})).hit);
}

TEST(Tick, TheEndOfASeamIsNoRim) {
    // A mushroom: a few samples on its cap, the others on its short stalk, so that the mean step is short for the cap.
    // In the middle of the cap the first row folds: that sample has no copy, though the surface is closed.
    State state = make_state(closed_chart(17, [](std::array<double, 3> n) {
        const bool cap = n[0] < -0.98;
        const double wide = cap ? 3 : 0.02;
        return std::array<double, 3>{cap ? n[0] : -0.5 + 0.05 * n[0], wide * n[1], wide * n[2]};
    }));
    ASSERT_EQ(state.class_of(8), kNone);
    const float beside = 0.18f;
    ASSERT_GT(beside, 1.2f * state.mean_step());
    const ToolOutput out = one(state, table_of(9, 6), options_of(2), tool_at({-0.97f, beside, 0}));
    EXPECT_EQ(out.sample, 8u);
    EXPECT_TRUE(out.hit);
}

TEST(Tick, PokeSticksAndGraspPulls) {
    State state = make_state(grid_chart(31, 31, flat));
    const DeformTable table = table_of(9, 6);
    const TickOptions o = options_of(5);
    EXPECT_FALSE(one(state, table, o, tool_at({12, 12, 0.2f}, ToolKind::Poke)).holding);
    EXPECT_TRUE(one(state, table, o, tool_at({12, 12, -0.2f}, ToolKind::Poke)).holding);
    ToolOutput out = one(state, table, o, tool_at({14.5f, 12, -1}, ToolKind::Poke));
    EXPECT_EQ(out.contact, 12u * 31 + 12) << "the sample first hit";
    EXPECT_NEAR(out.displacement.x, 2.5, 1e-6);
    EXPECT_NEAR(out.displacement.z, -1, 1e-6);
    EXPECT_NEAR(state.positions().x[12 * 31 + 12], 14.5, 1e-5);
    EXPECT_FALSE(one(state, table, o, tool_at({14.5f, 12, 0.1f}, ToolKind::Poke)).holding);
    EXPECT_EQ(state.positions().x[12 * 31 + 12], 12.0f);

    out = one(state, table, o, tool_at({20, 20, 0.5f}, ToolKind::Grasp, 1));
    EXPECT_TRUE(out.holding);
    EXPECT_EQ(out.displacement, (Vec3{0, 0, 0}));
    out = one(state, table, o, tool_at({20, 21, 2.5f}, ToolKind::Grasp, 1));
    EXPECT_EQ(out.contact, 20u * 31 + 20);
    EXPECT_NEAR(state.positions().z[20 * 31 + 20], 2, 1e-6);
    EXPECT_NEAR(state.positions().y[20 * 31 + 20], 21, 1e-5);
    ToolInput let_go = tool_at({20, 21, 2.5f}, ToolKind::Grasp, 1);
    let_go.engaged = false;
    out = one(state, table, o, let_go);
    EXPECT_FALSE(out.holding);
    EXPECT_EQ(out.force, (Vec3{0, 0, 0}));
    EXPECT_EQ(state.positions().z[20 * 31 + 20], 0.0f);
    EXPECT_FALSE(one(state, table, o, tool_at({20, 21, 9}, ToolKind::Grasp, 1)).holding) << "too far away";
}

TEST(Tick, SeveralToolsAddUp) {
    State state = make_state(grid_chart(41, 41, flat));
    const DeformTable table = table_of(9, 8);
    const ToolInput in[2] = {tool_at({15, 15, -1}, ToolKind::Touch, 0), tool_at({18, 17, -0.5f}, ToolKind::Touch, 3)};
    for (int turn = 0; turn < 3; ++turn) {
        ToolOutput out[2];
        const auto done = tick(state, table, options_of(3), in, out);
        ASSERT_TRUE(done.ok());
        EXPECT_EQ(done.value().contacts, 2u);
        EXPECT_NEAR(out[1].displacement.z, -0.5, 1e-6) << "does not feel the other's dent";
        for (int i = 0; i < 41; ++i)
            for (int j = 0; j < 41; ++j) {
                const auto w = [&](int ic, int jc) {
                    const int di = i - ic, dj = j - jc;
                    return std::abs(di) < 8 && std::abs(dj) < 8 ? std::exp(-(di * di + dj * dj) / 9.0) : 0;
                };
                ASSERT_NEAR(state.positions().z[i * 41 + j], -w(15, 15) - 0.5 * w(18, 17), 2e-6);
                ASSERT_TRUE(same_bits(state.normals()[static_cast<std::size_t>(i * 41 + j)],
                                      state.normal(static_cast<std::uint32_t>(i * 41 + j))));
            }
    }
}

TEST(Tick, ReleasedSurfaceFadesAtTheStatedRate) {
    State state = make_state(grid_chart(41, 41, flat, tube_seams(41, 41)));
    const DeformTable table = table_of(9, 8);
    TickOptions o = options_of(3);
    o.relax_rate = 50;
    o.dt = 0.002f;
    for (int k = 0; k < 100; ++k) one(state, table, o, tool_at({20, 2, -1}));
    // Held for 0.2 s: eq. 7 to the part e^-10 of the transient, exact at the contact.
    EXPECT_NEAR(state.positions().z[20 * 41 + 2], -1, 1e-6);
    EXPECT_NEAR(state.positions().z[22 * 41 + 5], -std::exp(-13 / 9.0), 1e-4);
    const float held = state.positions().z[22 * 41 + 5];
    for (int k = 0; k < 10; ++k) one(state, table, o, tool_at({20, 2, 5}));
    EXPECT_NEAR(state.positions().z[22 * 41 + 5], held * std::exp(-1.0), 1e-6);
    for (int k = 0; k < 400; ++k) {
        one(state, table, o, tool_at({20, 2, 5}));
        for (std::uint32_t i = 0; i < 41; ++i)
            ASSERT_TRUE(same_bits(state.positions()[i * 41], state.positions()[i * 41 + 40]));
    }
    for (std::size_t k = 0; k < 41 * 41; ++k) ASSERT_TRUE(same_bits(state.positions()[k], state.rest_positions()[k]));
}

TEST(Tick, PlasticSurfaceStaysWhereTheToolLeftIt) {
    State state = make_state(grid_chart(31, 31, flat));
    const DeformTable table = table_of(9, 6);
    TickOptions o = options_of(3);
    o.mode = DeformMode::Plastic;
    for (int k = 0; k < 20; ++k) one(state, table, o, tool_at({15, 15, -1}));
    EXPECT_NEAR(state.positions().z[15 * 31 + 15], -1, 1e-5);
    one(state, table, o, tool_at({15, 15, 3}));
    EXPECT_NEAR(state.positions().z[15 * 31 + 15], -1, 1e-5);
    EXPECT_NEAR(nearest_sample(state, {15, 15, -1}).value().distance, 0, 1e-5);
    for (int k = 0; k < 5; ++k)
        one(state, table, o, tool_at({15, 15, -1 + 0.5f * static_cast<float>(k)}, ToolKind::Grasp));
    EXPECT_NEAR(state.positions().z[15 * 31 + 15], 1, 1e-5) << "pulled by 2 in all, not by the sum of 0.5 to 2";
}

/// A tube with folds: near sheets that are far apart along the surface.
Point wavy_tube(double i, double j) {
    const double a = 2 * kPi * j / 40, r = 3 + 2.5 * std::sin(3 * a) * std::cos(i / 4);
    return {static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)), static_cast<float>(i / 5)};
}

Nearest exhaustive(const PointView& p, const State& state, Vec3 tool) {
    float best = std::numeric_limits<float>::infinity();
    std::uint32_t sample = kNone;
    for (std::uint32_t k = 0; k < p.count; ++k) {
        const Vec3 d = p[k] - tool;
        if (state.on_surface(k) && dot(d, d) < best) {
            best = dot(d, d);
            sample = k;
        }
    }
    return {sample, std::sqrt(best)};
}

/// Random walks with small steps, large steps and jumps, near folds and across the seam; the surface is being pressed.
/// The permanent shape is what tools are tracked against; it is read back after release().
void walk(const ChartSpec& chart, int steps, std::uint32_t seed, DeformMode mode) {
    State state = make_state(chart), shape = make_state(chart);
    const DeformTable table = table_of(5, 5);
    TickOptions o = options_of(0.5f);
    o.mode = mode;
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(-1, 1);
    Vec3 tool{3, 0, 4};
    int searched = 0;
    for (int k = 0; k < steps; ++k) {
        const float size = k % 1000 == 0 ? 8.0f : k % 7 == 0 ? 0.3f : 0.02f;
        tool = tool + Vec3{size * unit(random), size * unit(random), size * unit(random)};
        if (dot(tool, tool) > 100) tool = {2, 1, 4};
        o.d_max = mode == DeformMode::Plastic ? 0.01f : 0.5f;
        const ToolOutput out = one(state, table, o, tool_at(tool));
        searched += out.lost ? 1 : 0;
        const Nearest want = exhaustive(shape.positions(), shape, tool);
        ASSERT_EQ(out.sample, want.sample) << "step " << k;
        ASSERT_EQ(out.distance, want.distance) << "step " << k;
        if (mode == DeformMode::Plastic && out.contact != kNone) {
            Touch touch;
            touch.sample = out.contact;
            touch.displacement = out.displacement;
            touch.footprint = o.footprint;
            touch.d_max = 1;  // is clamped already
            touch.mode = DeformMode::Plastic;
            ASSERT_TRUE(deform(shape, table, touch).ok());
        }
    }
    EXPECT_GT(searched, steps / 2000);
    // Where the tool stays near a surface of many samples, the window is enough for most steps.
    if (chart.rows > 40) { EXPECT_LT(searched, steps / 2); }
}

/// Random steps of the property tests, of which a share goes to each surface. DGM_PROPERTY_STEPS=1000000 takes a
/// minute.
int property_steps() {
    return static_cast<int>(std::max(asked("DGM_PROPERTY_STEPS", 100000), 1000L));
}

TEST(Tick, NearestIsNeverWrong) {
    walk(grid_chart(43, 41, wavy_tube, tube_seams(43, 41)), property_steps() / 2, 1, DeformMode::Elastic);
    walk(free_chart(30, 21, wavy_tube), property_steps() / 5, 2, DeformMode::Elastic);
    walk(grid_chart(17, 17, sheet, octahedral_seams(17)), property_steps() / 10, 4, DeformMode::Elastic);
}
TEST(Tick, NearestIsNeverWrongOnAYieldingSurface) {
    walk(grid_chart(43, 41, wavy_tube, tube_seams(43, 41)), property_steps() / 5, 3, DeformMode::Plastic);
}

TEST(Tick, TrackingWithACertificateFindsWhatTheWindowLost) {
    State state = make_state(grid_chart(43, 41, wavy_tube, tube_seams(43, 41)));
    std::mt19937 random(8);
    std::uniform_real_distribution<float> x(-6, 6), z(-1, 9);
    std::uint32_t last = 0;
    int lost = 0;
    for (int k = 0; k < 5000; ++k) {
        const Vec3 tool{x(random), x(random), z(random)};
        const auto local = track_sample(state, tool, last, 2);
        const auto found = track_nearest(state, tool, last, 2);
        const Nearest want = exhaustive(state.positions(), state, tool);
        ASSERT_EQ(found.value().sample, want.sample);
        ASSERT_EQ(found.value().lost, local.value().distance > want.distance);
        lost += found.value().lost ? 1 : 0;
        last = found.value().sample;
    }
    EXPECT_GT(lost, 1000);
    EXPECT_LT(lost, 5000);
}

/// Largest change of the force from tick to tick on a path that does not depend on the number of ticks.
double largest_jump(const ChartSpec& chart, ContactRule rule, ToolKind kind, int ticks) {
    State state = make_state(chart);
    const DeformTable table = table_of(5, 5);
    TickOptions o = options_of(1, 1, 0.02f);
    o.rule = rule;
    o.dt = 1.0f / static_cast<float>(ticks);
    Vec3 before{};
    double worst = 0;
    for (int k = 0; k < ticks; ++k) {
        const double t = static_cast<double>(k) / ticks, a = 2 * kPi * t;
        // In and out of a wavy tube, round it and across its seam, through its folds.
        const double r = 2.6 + 1.6 * std::sin(5 * a);
        ToolInput in = tool_at({static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)),
                                static_cast<float>(4 + 3 * std::sin(2 * a))},
                               kind);
        in.engaged = kind != ToolKind::Grasp || std::sin(9 * a) > 0;
        const ToolOutput out = one(state, table, o, in);
        const Vec3 d = out.force - before;
        if (k > 0) worst = std::max(worst, std::sqrt(double{dot(d, d)}));
        before = out.force;
    }
    return worst;
}

TEST(Tick, ForceIsContinuousInTime) {
    // Outward normals: columns run the other way round.
    const auto outside = [](double i, double j) { return wavy_tube(i, 40 - j); };
    const ChartSpec chart = grid_chart(43, 41, outside, tube_seams(43, 41));
    for (const ToolKind kind : {ToolKind::Touch, ToolKind::Poke, ToolKind::Grasp}) {
        const double coarse = largest_jump(chart, ContactRule::Smooth, kind, 2000);
        const double fine = largest_jump(chart, ContactRule::Smooth, kind, 32000);
        EXPECT_LT(fine, coarse / 6) << "16 times shorter ticks, " << coarse << " to " << fine;
        EXPECT_LT(fine, 0.03);
    }
    // As printed it jumps however short the ticks.
    EXPECT_GT(largest_jump(chart, ContactRule::Printed, ToolKind::Touch, 32000), 0.1);
}

TEST(Tick, StepsOfTheDisplacementKeepTheirBound) {
    const auto outside = [](double i, double j) { return wavy_tube(i, 40 - j); };
    State state = make_state(grid_chart(43, 41, outside, tube_seams(43, 41)));
    const DeformTable table = table_of(5, 5);
    TickOptions o = options_of(2, 1, 0.01f);
    std::mt19937 random(11);
    std::uniform_real_distribution<float> unit(-1, 1);
    Vec3 tool{3, 0, 4}, d{};
    one(state, table, o, tool_at(tool));
    for (int k = 0; k < 20000; ++k) {
        const Vec3 step{0.03f * unit(random), 0.03f * unit(random), 0.03f * unit(random)};
        tool = tool + step;
        if (dot(tool, tool) > 60) tool = tool - 2 * step;
        const Vec3 change = one(state, table, o, tool_at(tool)).displacement - d;
        d = d + change;
        // An offset fades; it is never longer than the jump, here 4 d_max at most.
        ASSERT_LE(std::sqrt(dot(change, change)), 2 * std::sqrt(dot(step, step)) + (1 - std::exp(-0.1f)) * 8 + 1e-4f);
    }
}

TEST(Tick, BadInputsAreRefusedWithoutHarm) {
    State state = make_state(grid_chart(31, 31, flat));
    const DeformTable table = table_of(9, 6);
    const TickOptions good = options_of(2);
    one(state, table, good, tool_at({12, 17, -0.5f}));
    const Vec3 before = state.positions()[12 * 31 + 17];
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    ToolOutput out;
    const auto code = [&](const TickOptions& o, const ToolInput& in) {
        return tick(state, table, o, {&in, 1}, {&out, 1}).error().code;
    };
    for (const float bad : {nan, infinity, -infinity}) {
        EXPECT_EQ(code(good, tool_at({bad, 0, 0})), ErrorCode::BadArgument);
        EXPECT_EQ(code(good, tool_at({0, 0, bad})), ErrorCode::BadArgument);
        TickOptions o = good;
        o.dt = bad;
        EXPECT_EQ(code(o, tool_at({0, 0, 0})), ErrorCode::BadArgument);
        o = good;
        o.d_max = bad;
        EXPECT_EQ(code(o, tool_at({0, 0, 0})), ErrorCode::BadArgument);
        o = good;
        o.f_max = bad;
        EXPECT_EQ(code(o, tool_at({0, 0, 0})), ErrorCode::BadArgument);
    }
    EXPECT_EQ(code(good, tool_at({0, 0, 0}, ToolKind::Touch, 4)), ErrorCode::BadArgument);
    EXPECT_EQ(code(good, tool_at({0, 0, 0}, static_cast<ToolKind>(3))), ErrorCode::Unsupported);
    TickOptions unknown = good;
    unknown.footprint = static_cast<Footprint>(4);
    EXPECT_EQ(code(unknown, tool_at({0, 0, 0})), ErrorCode::Unsupported);
    const ToolInput twice[2] = {tool_at({0, 0, 0}), tool_at({1, 0, 0})};
    ToolOutput two[2];
    EXPECT_EQ(tick(state, table, good, twice, two).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(tick(state, table, good, {twice, 1}, {two, 0}).error().code, ErrorCode::Ok) << "no outputs wanted";
    one(state, table, good, tool_at({12, 17, -0.5f}));
    EXPECT_TRUE(same_bits(state.positions()[12 * 31 + 17], before));
    EXPECT_EQ(code(good, tool_at({0, -2e18f, 0})), ErrorCode::BadArgument) << "beyond kMaxCoordinate";
    EXPECT_EQ(code(good, tool_at({3e38f, 0, 0})), ErrorCode::BadArgument);
    // Legal but absurd places do no harm either.
    for (const float far : {1e10f, 1e17f, 1e18f}) {
        const ToolOutput there = one(state, table, good, tool_at({far, -far, far}));
        EXPECT_TRUE(std::isfinite(there.displacement.z) && std::isfinite(there.force.z));
        EXPECT_LT(there.sample, 31u * 31);
    }
    EXPECT_NEAR(one(state, table, good, tool_at({12, 17, -0.5f})).displacement.z, -0.5, 1e-6);
    EXPECT_EQ(state.relax(-1, 1).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(state.relax(1, nan).error().code, ErrorCode::BadArgument);
}

TEST(Tick, OneContactInOnePassIsTheSameAsStepByStep) {
    // Slides over a surface with a seam: the quick case, the seam case and every change between them.
    const ChartSpec chart = grid_chart(41, 41, flat, tube_seams(41, 41));
    State quick = make_state(chart), slow = make_state(chart);
    const DeformTable table = table_of(9, 7);
    for (int k = 0; k < 400; ++k) {
        const float i = 20 + 15 * std::sin(0.05f * static_cast<float>(k)), j = static_cast<float>(k % 40);
        const ToolOutput out = one(quick, table, options_of(2), tool_at({i, j, k % 9 == 0 ? 1.0f : -0.7f}));
        slow.release();
        if (out.contact != kNone) {
            Touch touch;
            touch.sample = out.contact;
            touch.displacement = out.displacement;
            touch.d_max = 2;
            touch.footprint = Footprint::Grid;
            ASSERT_TRUE(deform(slow, table, touch).ok());
        }
        for (std::size_t s = 0; s < 41 * 41; ++s) {
            ASSERT_TRUE(same_bits(quick.positions()[s], slow.positions()[s])) << k << ' ' << s;
            ASSERT_TRUE(same_bits(quick.normals()[s], slow.normal(static_cast<std::uint32_t>(s)))) << k << ' ' << s;
        }
        if (k % 13 == 0) {
            ASSERT_EQ(nearest_sample(quick, {i, j, -0.3f}).value().sample,
                      nearest_sample(slow, {i, j, -0.3f}).value().sample);
        }
    }
}

TEST(Tick, NothingDriftsOverManyTicks) {
    State state = make_state(grid_chart(41, 41, flat, tube_seams(41, 41)));
    const DeformTable table = table_of(9, 7);
    TickOptions o = options_of(2, 1, 0.01f);
    o.relax_rate = 80;
    for (int k = 0; k < 100000; ++k) {
        const float t = 0.002f * static_cast<float>(k);
        one(state, table, o, tool_at({20 + 10 * std::sin(t), 20 + 19 * std::sin(1.7f * t), 0.5f * std::sin(9 * t)}));
    }
    for (int k = 0; k < 600; ++k) one(state, table, o, tool_at({20, 20, 5}));
    for (std::size_t s = 0; s < 41 * 41; ++s) ASSERT_TRUE(same_bits(state.positions()[s], state.rest_positions()[s]));
}

}  // namespace
}  // namespace dgm::test
