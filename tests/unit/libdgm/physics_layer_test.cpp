// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/physics_layer_test.cpp
// The soft layer between a surface and tools: its law, its energy, and a force that does not jump.
#include <dgm/compliance.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "physics_shapes.h"

namespace dgm::test {
namespace {

constexpr float kLayer = 2e6f;  // N/m^3
constexpr double kRadius = 10e-3;

StepOptions soft_ball(std::uint32_t cycles, float layer = kLayer) {
    StepOptions o;
    o.cycles = cycles;
    o.tool_radius = float(1e3 * kRadius);
    o.tool_layer = layer;
    return o;
}
/// Of 10 mm radius, above the middle of organ_chart() with its lowest point `depth` mm below the top.
ToolInput ball_at(double depth, double along = 0) {
    ToolInput in;
    in.position = {float(along), 0, float(60 - depth)};
    return in;
}

/// A sheet of `size` mm whose foundation does not give way.
ChartSpec hard_sheet(std::uint32_t side, double size) {
    return grid_chart(side, side, [=](double i, double j) {
        return Point{float(size * i / (side - 1) - size / 2), float(size * j / (side - 1) - size / 2), 0};
    });
}
double force_on_hard_sheet(std::uint32_t side, double size, double depth, double along = 0) {
    PhysicsOptions options{.material = Material{}};
    options.material->foundation = 1e11f;
    options.dt = 0.1f;
    Body body(hard_sheet(side, size), options);
    ToolInput in;
    in.position = {float(along), 0, float(1e3 * (kRadius - depth))};
    StepTool answer;
    StepReport report;
    for (int k = 0; k < 20; ++k) report = step(body.state, body.physics, soft_ball(20), {&in, 1}, {&answer, 1}).value();
    // The springs are as long as the ball is deep along its radius: K pi (R d^3 / 3 - d^4 / 4).
    const double cube = depth * depth * depth;
    const double held = double{kLayer} * std::numbers::pi * cube * (kRadius / 3 - depth / 4);
    EXPECT_NEAR(report.layers, held, 0.07 * held) << side << ' ' << along;
    return double(answer.force.z);
}

TEST(PhysicsLayer, IsAMattressUnderABall) {
    // Springs side by side, K N/m^3, under a ball that reaches d deep: K pi (R - d) d^2 [Johnson 1985, 4.3].
    const auto exact = [](double d) { return double{kLayer} * std::numbers::pi * (kRadius - d) * d * d; };
    // So shallow that one cell holds all of the patch.
    EXPECT_NEAR(force_on_hard_sheet(17, 40, 0.05e-3), exact(0.05e-3), 0.01 * exact(0.05e-3));
    // Many cells: what a cell leaves out at the patch's border shrinks with the cells.
    double before = 1;
    for (const std::uint32_t side : {17u, 33u, 65u}) {
        const double off = std::fabs(force_on_hard_sheet(side, 12, 1e-3) / exact(1e-3) - 1);
        EXPECT_LT(off, side == 65 ? 0.01 : before) << side;
        before = off;
    }
    // Wherever the ball lies on the grid.
    for (const double along : {0.05, 0.12})
        EXPECT_NEAR(force_on_hard_sheet(65, 12, 1e-3, along), exact(1e-3), 0.02 * exact(1e-3)) << along;
}

TEST(PhysicsLayer, ForceIsTheSlopeOfTheEnergy) {
    PhysicsOptions options{.material = Material{}};
    options.dt = 0.1f;
    Body body(organ_chart(33), options);
    const auto settle = [&](double depth, double along, double& energy) {
        StepTool answer;
        StepReport r;
        const ToolInput in = ball_at(depth, along);
        for (int k = 0; k < 80; ++k) r = step(body.state, body.physics, soft_ball(10), {&in, 1}, {&answer, 1}).value();
        energy = r.elastic + r.layers;
        return answer.force;
    };
    // Shallow, where one cell is in touch, deep, and beside the sample in the middle.
    for (const double along : {0.0, 1.7})
        for (const double depth : {0.6, 2.0, 6.0}) {
            double low = 0, middle = 0, high = 0;
            const double by = 0.05 * depth;
            settle(depth - by, along, low);
            const double force = double{settle(depth, along, middle).z};
            settle(depth + by, along, high);
            EXPECT_GT(force, 1e-3);
            EXPECT_NEAR((high - low) / (2e-3 * by), force, 0.01 * force) << depth << ' ' << along;
        }
}

/// Largest change of the force in a tick, over the largest force, of a ball that comes, goes in by 10 mm and leaves.
double largest_jump(float layer, double speed) {
    PhysicsOptions options{.material = Material{}};
    options.material->viscosity = 2e-3f;
    Body body(organ_chart(33), options);
    const int ticks = int(11 / speed);  // mm, mm a tick
    double most = 0, jump = 0;
    Vec3 before;
    for (int k = 0; k <= 2 * ticks + 20; ++k) {
        const double part = 0.5 - 0.5 * std::cos(std::numbers::pi * k / ticks);
        const ToolInput in = ball_at(k <= 2 * ticks ? 11 * part - 1 : -1);
        StepTool answer;
        EXPECT_FALSE(step(body.state, body.physics, soft_ball(5, layer), {&in, 1}, {&answer, 1}).value().clamped);
        const Vec3 change = answer.force - before;
        jump = std::max(jump, std::sqrt(double{dot(change, change)}));
        most = std::max(most, std::sqrt(double{dot(answer.force, answer.force)}));
        before = answer.force;
    }
    return jump / most;
}
TEST(PhysicsLayer, ForceDoesNotJump) {
    // The force grows over 11 mm: at its quickest by pi / 2 of the mean, and stiffer towards the end.
    for (const double speed : {0.02, 0.05}) EXPECT_LE(largest_jump(kLayer, speed), 5 * speed / 11) << speed;
    EXPECT_LE(largest_jump(kLayer, 0.02), 0.01);
    EXPECT_GT(largest_jump(0, 0.05), 2 * largest_jump(kLayer, 0.05)) << "a hard ball meets a sample's mass at once";
}

TEST(PhysicsLayer, TheHardBallIsTheLimitOfStiffLayers) {
    const auto press = [](float layer) {
        PhysicsOptions options{.material = Material{}};
        options.dt = 0.1f;
        Body body(organ_chart(33), options);
        StepTool answer;
        const ToolInput in = ball_at(6);
        for (int k = 0; k < 80; ++k)
            EXPECT_TRUE(step(body.state, body.physics, soft_ball(10, layer), {&in, 1}, {&answer, 1}).ok());
        return double{answer.force.z};
    };
    const double hard = press(0), soft = press(kLayer);
    EXPECT_LT(soft, hard);
    EXPECT_NEAR(press(1e10f), hard, 0.01 * hard);
}

TEST(PhysicsLayer, SameBitsAndNumbersThatAreRefused) {
    const auto run = [](bool plain) {
        Body body(organ_chart(33), {}, plain);
        std::vector<float> bits;
        for (int k = 0; k < 30; ++k) {
            const ToolInput in = ball_at(0.2 * k, 0.1 * k);
            StepTool answer;
            EXPECT_TRUE(step(body.state, body.physics, soft_ball(3), {&in, 1}, {&answer, 1}).ok());
            bits.insert(bits.end(), {answer.force.x, answer.force.y, answer.force.z});
        }
        const PointView now = body.state.positions();
        for (std::uint32_t k = 0; k < now.count; ++k) bits.insert(bits.end(), {now[k].x, now[k].y, now[k].z});
        return bits;
    };
    const std::vector<float> first = run(false), plain = run(true);
    ASSERT_EQ(first.size(), plain.size());
    EXPECT_EQ(std::memcmp(first.data(), plain.data(), first.size() * sizeof(float)), 0);
    Body body(organ_chart(17));
    const ToolInput in = ball_at(1);
    for (const float layer :
         {-1.0f, 0.5f, 2e12f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        const auto done = step(body.state, body.physics, soft_ball(3, layer), {&in, 1});
        ASSERT_FALSE(done.ok()) << layer;
        EXPECT_EQ(done.error().code, ErrorCode::BadArgument) << layer;
    }
    Compliance compliance = Compliance::create(body.state, body.physics).value();
    const auto published = compliance.publish(body.state, body.physics, soft_ball(3), {&in, 1});
    ASSERT_FALSE(published.ok());
    EXPECT_EQ(published.error().code, ErrorCode::Unsupported);
}

TEST(PhysicsLayer, PushesABodyThatLiesFreeAndLetsItGo) {
    // Without a foundation the ball sends the body away; what the layer holds goes into motion and no more.
    PhysicsOptions options{.material = Material{}};
    options.material->foundation = 0;
    Body body(organ_chart(17), options);
    double work = 0;
    StepReport r;
    for (int k = 0; k < 300; ++k) {
        const double depth = std::min(0.1 * k, 4.0);
        const ToolInput in = ball_at(depth);
        StepTool answer;
        r = step(body.state, body.physics, soft_ball(5), {&in, 1}, {&answer, 1}).value();
        // Implicit steps take the force at the end of the tick, so work is not below what the body gets.
        if (k > 0 && k <= 40) work += 1e-4 * double{answer.force.z};
        EXPECT_LE(r.kinetic + r.elastic + r.layers, work * 1.001 + 1e-9) << k;
    }
    EXPECT_EQ(r.contacts, 0u) << "it flies away";
    EXPECT_GT(r.kinetic, 0.2 * work);
}

}  // namespace
}  // namespace dgm::test
