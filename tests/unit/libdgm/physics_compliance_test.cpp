// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/physics_compliance_test.cpp
// Local compliances: their force is that of the next step at the place of the tool, and publishing changes nothing.
#include <gtest/gtest.h>

#include <dgm/compliance.h>
#include <dgm/dgm_physics.h>

#include <atomic>
#include <limits>

#include "physics_shapes.h"
#ifndef __wasm__
#include <thread>
#endif

namespace dgm::test {
namespace {

constexpr float kDt = 0.01f, kRadius = 15;

double length(Vec3 v) {
    return std::sqrt(double{v.x} * double{v.x} + double{v.y} * double{v.y} + double{v.z} * double{v.z});
}
PhysicsOptions flesh() {
    PhysicsOptions o;
    o.dt = kDt;
    o.material = Material{};
    o.material->viscosity = 2e-3f;
    return o;
}

/// A ball that presses 8 mm deep into the top of an organ within 0.1 s and stays there.
struct Pressed {
    Body body{organ_chart(33), flesh()};
    Compliance compliance = Compliance::create(body.state, body.physics).value();
    ComplianceReader reader = ComplianceReader::create(compliance).value();
    StepOptions how;
    ToolInput tool;
    StepTool felt;
    ComplianceReport last;
    explicit Pressed(int steps, bool publishes = true, ToolKind kind = ToolKind::Touch) {
        how.cycles = 5;
        how.tool_radius = kRadius;
        tool.kind = kind;
        for (int k = 0; k < steps; ++k) {
            const float share = std::min(1.0f, kDt * static_cast<float>(k) / 0.1f);
            tool.position = kind == ToolKind::Grasp ? Vec3{5, 3, 49 + 4 * share} : Vec3{5, 3, 65 - 8 * share};
            go(publishes);
        }
    }
    void go(bool publishes) {
        EXPECT_TRUE(step(body.state, body.physics, how, {&tool, 1}, {&felt, 1}).ok());
        if (!publishes) return;
        auto done = compliance.publish(body.state, body.physics, how, {&tool, 1});
        ASSERT_TRUE(done.ok()) << done.error().message;
        last = done.value();
    }
    Vec3 feel(Vec3 way) {
        ToolInput there = tool;
        there.position = there.position + way;
        ComplianceAnswer answer;
        EXPECT_TRUE(compliance_tick(reader, {&there, 1}, {&answer, 1}).ok());
        return answer.force;
    }
    /// What the converged next step answers there.
    Vec3 step_there(Vec3 way) {
        tool.position = tool.position + way;
        how.cycles = 60;
        go(false);
        return felt.force;
    }
};

constexpr Vec3 kWays[] = {{0, 0, 0}, {0, 0, -0.5f}, {0, 0, -1}, {0, 0, -2}, {0, 0, 1}, {1, 0, 0}, {2, 0, -1}};

TEST(Compliance, ForceIsThatOfTheNextStep) {
    // At rest 2 % for moves of up to 2.2 mm within a step of 10 ms; while the ball goes in at 80 mm/s, 10 % of the
    // force of 0.12 N then.
    for (const int steps : {6, 25}) {
        Pressed here(steps);
        EXPECT_EQ(here.last.left_out, 0u);
        EXPECT_GE(here.last.samples, 8u);
        for (const Vec3 way : kWays) {
            Pressed other(steps, false);
            const Vec3 wanted = other.step_there(way), found = here.feel(way);
            const double most = steps == 25 ? 0.02 * length(wanted) : 0.1 * std::max(0.12, length(wanted));
            EXPECT_LE(length(found - wanted), most) << steps << ": " << way.x << " " << way.z;
            EXPECT_GT(length(wanted), 0.02);
        }
    }
}

TEST(Compliance, GraspPullsAsTheNextStep) {
    // A grasp that has pulled by 4 mm, with 0.6 N: 2 % of that for moves of 1 mm in a step, 8 % for 2 mm.
    double pulled = 0;
    for (const Vec3 way : {Vec3{0, 0, 0}, Vec3{0, 0, -1}, Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{0, 0, -2}}) {
        Pressed here(25, true, ToolKind::Grasp), other(25, false, ToolKind::Grasp);
        const Vec3 wanted = other.step_there(way), found = here.feel(way);
        if (pulled == 0) pulled = length(wanted);
        EXPECT_LE(length(found - wanted), (length(way) > 1 ? 0.08 : 0.02) * pulled) << way.x << " " << way.z;
    }
    EXPECT_GT(pulled, 0.3);
}

TEST(Compliance, StiffnessOfAGraspIsSymmetric) {
    Pressed here(25, true, ToolKind::Grasp);
    const Vec3 at = here.feel({});
    const Vec3 rows[3] = {here.feel({1, 0, 0}) - at, here.feel({0, 1, 0}) - at, here.feel({0, 0, 1}) - at};
    EXPECT_LT(rows[0].x, 0);
    EXPECT_LT(rows[1].y, 0);
    EXPECT_LT(rows[2].z, 0);
    const double scale = std::max({length(rows[0]), length(rows[1]), length(rows[2])});
    EXPECT_NEAR(rows[0].y, rows[1].x, 0.01 * scale);
    EXPECT_NEAR(rows[0].z, rows[2].x, 0.01 * scale);
    EXPECT_NEAR(rows[1].z, rows[2].y, 0.01 * scale);
}

TEST(Compliance, PublishingChangesNoBit) {
    Pressed with(15), without(15, false);
    for (int k = 0; k < 5; ++k) {
        with.go(true);
        without.go(false);
    }
    EXPECT_EQ(with.felt.force, without.felt.force);
    const PointView a = with.body.state.positions(), b = without.body.state.positions();
    for (std::uint32_t k = 0; k < a.count; ++k) ASSERT_EQ(a[k], b[k]) << k;
}

TEST(Compliance, ToolThatLeavesFeelsNothing) {
    Pressed here(25);
    EXPECT_GT(length(here.feel({})), 0.1);
    EXPECT_EQ(here.feel({0, 0, 20}), Vec3{});
    ComplianceAnswer answer;
    here.tool.engaged = false;
    EXPECT_TRUE(compliance_tick(here.reader, {&here.tool, 1}, {&answer, 1}).ok());
    EXPECT_EQ(answer.force, Vec3{});
    here.tool.engaged = true;
    here.tool.kind = ToolKind::Grasp;  // was published as a touch
    EXPECT_TRUE(compliance_tick(here.reader, {&here.tool, 1}, {&answer, 1}).ok());
    EXPECT_EQ(answer.force, Vec3{});
    // Published as away.
    EXPECT_TRUE(here.compliance.publish(here.body.state, here.body.physics, here.how, {}).ok());
    here.tool.kind = ToolKind::Touch;
    EXPECT_EQ(here.feel({}), Vec3{});
}

TEST(Compliance, MoreSamplesThanColumnsShareThem) {
    Pressed here(25);
    const double wanted = length(here.feel({0, 0, -1}));
    ComplianceOptions few;
    few.columns = 2;
    few.renewed = 32;
    here.compliance = Compliance::create(here.body.state, here.body.physics, few).value();
    here.reader = ComplianceReader::create(here.compliance).value();
    here.go(true);
    EXPECT_EQ(here.last.columns, 2u);
    EXPECT_GT(here.last.samples, 2u);
    EXPECT_NEAR(length(here.feel({0, 0, -1})), wanted, 0.1 * wanted);
}

TEST(Compliance, HeldBodyAndSecondToolCount) {
    // A tool that holds the body beside the first one makes it stiffer there, and so do pins.
    const auto rise = [](bool pinned, bool second) {
        Pressed here(2);
        ComplianceOptions two;
        two.tools = 2;
        two.cycles = 4;
        here.compliance = Compliance::create(here.body.state, here.body.physics, two).value();
        here.reader = ComplianceReader::create(here.compliance).value();
        const ToolInput tools[2] = {{.tool = 0, .position = {5, 3, 60}},
                                    {.tool = 1, .kind = ToolKind::Grasp, .position = {22, 3, 45}}};
        StepTool answers[2];
        Pin pin;
        pin.sample = 0;
        double best = 1e9;
        const PointView rest = here.body.state.rest_positions();
        for (std::uint32_t k = 0; k < rest.count; ++k) {
            const double far = length(rest[k] - Vec3{22, 3, 45});
            if (far < best) {
                best = far;
                pin = {k, rest[k]};
            }
        }
        here.how.tool_radius = 12;
        if (pinned) here.how.pins = {&pin, 1};
        const std::span<const ToolInput> used(tools, second ? 2 : 1);
        for (int k = 0; k < 20; ++k) {
            EXPECT_TRUE(step(here.body.state, here.body.physics, here.how, used, answers).ok());
            EXPECT_TRUE(here.compliance.publish(here.body.state, here.body.physics, here.how, used).ok());
        }
        here.tool.position = tools[0].position;
        return length(here.feel({0, 0, -0.5f})) - length(here.feel({}));
    };
    const double alone = rise(false, false), pinned = rise(true, false), second = rise(false, true);
    EXPECT_GT(alone, 0.005);
    EXPECT_GT(pinned, 1.01 * alone);
    EXPECT_GT(second, 1.01 * alone);
}

TEST(Compliance, FadeSpreadsTheJumpOfAFrame) {
    Pressed here(12);
    ReaderOptions fades;
    fades.fade = 9;
    ComplianceReader slow = ComplianceReader::create(here.compliance, fades).value();
    const auto feel = [&](ComplianceReader& reader) {
        ComplianceAnswer answer;
        EXPECT_TRUE(compliance_tick(reader, {&here.tool, 1}, {&answer, 1}).ok());
        return length(answer.force);
    };
    const double before = feel(slow);
    EXPECT_DOUBLE_EQ(before, feel(here.reader));
    here.tool.position.z -= 0.5f;
    const double moved = feel(slow);
    here.go(true);
    const double after = feel(here.reader), jump = std::fabs(after - moved);
    double last = moved;
    EXPECT_GT(jump, 1e-4);
    for (int k = 0; k < 10; ++k) {
        const double now = feel(slow);
        EXPECT_LE(std::fabs(now - last), 0.11 * jump) << k;
        last = now;
    }
    EXPECT_NEAR(last, after, 1e-4 * after);
}

TEST(Compliance, DamperTakesWhatTheBodyGivesTooMuch) {
    // A tool that is engaged in a pressed body is pushed out of it, by energy that it has not put in. Damped, the push
    // is taken away but for that of one tick; and a tool that goes in first gets back what it gave.
    double energies[2][2];
    for (const bool damped : {false, true})
        for (const bool in_first : {false, true}) {
            Pressed here(25);
            ReaderOptions o;
            o.damper = damped ? 100.0f : 0.0f;
            here.reader = ComplianceReader::create(here.compliance, o).value();
            double at = in_first ? 10 : 0, energy = 0;
            Vec3 force = here.feel({0, 0, static_cast<float>(at)});
            const auto move = [&](double way) {
                at += way;
                energy -= double{force.z} * 1e-3 * way;
                force = here.feel({0, 0, static_cast<float>(at)});
            };
            for (int k = 0; k < 200 && in_first; ++k) move(-0.05);
            for (int k = 0; k < 200; ++k) move(0.05);
            energies[damped][in_first] = energy;
        }
    EXPECT_LT(energies[0][0], -5e-4);
    EXPECT_GT(energies[1][0], -5e-5);
    EXPECT_NEAR(energies[0][1], 0, 5e-5);
    EXPECT_GE(energies[1][1], -1e-6);
}

/// A device of 80 g that a hand presses into a body by a spring, along z, with forces at 1 kHz by what a step
/// of 10 ms lets the loop know. @return how far the device swings while the hand stands still, metres
double swing_of_loop(bool compliance, float stiffer) {
    PhysicsOptions o = flesh();
    for (float* modulus : {&o.material->membrane, &o.material->bending, &o.material->foundation}) *modulus *= stiffer;
    Pressed here(1);
    here.body = Body(organ_chart(17), o);
    here.compliance = Compliance::create(here.body.state, here.body.physics).value();
    ReaderOptions fade;
    fade.fade = 10;
    here.reader = ComplianceReader::create(here.compliance, fade).value();
    double z = 0.068, speed = 0, low = 1, high = 0, held = 0;
    for (int tick = 0; tick < 800; ++tick) {
        const double seen = 3e-5 * std::floor(z / 3e-5 + 0.5), hand = 0.068 - 0.013 * std::min(1.0, tick / 300.0);
        if (tick % 10 == 0 && tick > 0) {
            here.go(compliance);
            held = double{here.felt.force.z};
        }
        if (tick % 10 == 0) here.tool.position = {5, 3, static_cast<float>(1e3 * seen)};
        const Vec3 way = Vec3{5, 3, static_cast<float>(1e3 * seen)} - here.tool.position;
        const double force = compliance ? double{here.feel(way).z} : held;
        for (int part = 0; part < 20; ++part) {
            speed += 5e-5 / 0.08 * (force + 300 * (hand - z) - 2.3 * speed);
            z += 5e-5 * speed;
        }
        if (tick < 500) continue;
        low = std::min(low, z);
        high = std::max(high, z);
    }
    return high - low;
}
TEST(Compliance, ClosedLoopIsQuietWhereAHeldForceSwings) {
    EXPECT_LT(swing_of_loop(true, 8), 2.4e-4);
    EXPECT_GT(swing_of_loop(false, 8), 1e-3);
}

TEST(Compliance, RefusesByName) {
    Body body(organ_chart(17), flesh());
    const auto code = [&](ComplianceOptions o) { return Compliance::create(body.state, body.physics, o).error().code; };
    EXPECT_EQ(code({.tools = 0}), ErrorCode::BadArgument);
    EXPECT_EQ(code({.tools = 9}), ErrorCode::BadArgument);
    EXPECT_EQ(code({.columns = 0}), ErrorCode::BadArgument);
    EXPECT_EQ(code({.columns = 33}), ErrorCode::BadArgument);
    EXPECT_EQ(code({.cycles = 0}), ErrorCode::BadArgument);
    EXPECT_EQ(code({.max_bytes = 1000}), ErrorCode::LimitExceeded);
    Body other(organ_chart(33), flesh());
    EXPECT_EQ(Compliance::create(other.state, body.physics).error().code, ErrorCode::BadArgument);
    Compliance made = Compliance::create(body.state, body.physics).value();
    const auto refused = [&](ReaderOptions o) { return ComplianceReader::create(made, o).error().code; };
    EXPECT_EQ(refused({.fade = 1001}), ErrorCode::BadArgument);
    EXPECT_EQ(refused({.damper = -1}), ErrorCode::BadArgument);
    EXPECT_EQ(refused({.damper = std::numeric_limits<float>::quiet_NaN()}), ErrorCode::BadArgument);
    EXPECT_EQ(refused({.tick = 0}), ErrorCode::BadArgument);
    ComplianceReader reader = ComplianceReader::create(made).value();
    StepOptions how;
    how.tool_radius = 10;
    ToolInput tool;
    ComplianceAnswer answer;
    // Nothing has been published yet.
    EXPECT_TRUE(compliance_tick(reader, {&tool, 1}, {&answer, 1}).ok());
    EXPECT_EQ(answer.frame, 0u);
    EXPECT_EQ(answer.force, Vec3{});
    const auto published = [&](const StepOptions& o, const ToolInput& t) {
        return made.publish(body.state, body.physics, o, {&t, 1}).error().code;
    };
    tool.tool = 1;
    EXPECT_EQ(published(how, tool), ErrorCode::BadArgument);
    tool.tool = 0;
    EXPECT_EQ(published({}, tool), ErrorCode::BadArgument);  // a tool without radius
    tool.position.x = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(published(how, tool), ErrorCode::BadArgument);
    EXPECT_EQ(compliance_tick(reader, {&tool, 1}, {&answer, 1}).error().code, ErrorCode::BadArgument);
    tool.position.x = 0;
    EXPECT_EQ(compliance_tick(reader, {&tool, 1}, {}).error().code, ErrorCode::BadArgument);
    StepOptions soft = how, rough = how;
    soft.tool_layer = 1e6f;
    rough.friction = 0.5f;
    EXPECT_EQ(published(soft, tool), ErrorCode::Unsupported);
    EXPECT_EQ(published(rough, tool), ErrorCode::Unsupported);
    const Pin pins[2] = {{5, {}}, {5, {}}};
    how.pins = pins;
    EXPECT_EQ(published(how, tool), ErrorCode::BadArgument);
    EXPECT_EQ(made.publish(other.state, other.physics, {}, {}).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(made.publish(body.state, body.physics, {}, {}).value().frame, 1u);
}

TEST(Compliance, SameBitsWithPlainLoops) {
    Vec3 forces[2];
    for (const bool plain : {false, true}) {
        PhysicsOptions o = flesh();
        o.plain_loops = plain;
        Pressed here(1);
        here.body = Body(organ_chart(33), o);
        for (int k = 0; k < 10; ++k) {
            here.tool.position = {5, 3, 65 - static_cast<float>(k)};
            here.go(true);
        }
        forces[plain ? 1 : 0] = here.feel({0.3f, 0, -0.7f});
    }
    EXPECT_EQ(forces[0], forces[1]);
    EXPECT_GT(length(forces[0]), 0.05);
}

#ifndef __wasm__
TEST(Compliance, ThreadsNeitherWaitNorMix) {
    // Every force is that of one published frame: frames alternate between a ball in touch and none.
    Pressed here(25);
    const Vec3 wanted = here.feel({});
    std::atomic<bool> stop{false};
    std::thread writer([&] {
        for (int k = 0; k < 100; ++k) {
            const std::size_t tools = k % 2;
            if (!here.compliance.publish(here.body.state, here.body.physics, here.how, {&here.tool, tools}).ok()) break;
        }
        stop = true;
    });
    long mixed = 0, ticks = 0;
    ComplianceReader reader = ComplianceReader::create(here.compliance).value();
    do {
        ComplianceAnswer answer;
        if (!compliance_tick(reader, {&here.tool, 1}, {&answer, 1}).ok()) ++mixed;
        const double off = length(answer.force - wanted);
        if (answer.contacts != 0 && !(off < 0.02 * length(wanted))) ++mixed;
        if (answer.contacts == 0 && length(answer.force) != 0) ++mixed;
        ++ticks;
    } while (!stop);
    writer.join();
    EXPECT_EQ(mixed, 0);
    EXPECT_GT(ticks, 0);
}
#endif

TEST(Compliance, InC) {
    const Image image = build({organ_chart(33)});
    dgm_asset* asset = nullptr;
    ASSERT_EQ(dgm_asset_open_memory(image.bytes.data(), image.bytes.size(), nullptr, nullptr, &asset, nullptr), DGM_OK);
    dgm_state* state = nullptr;
    ASSERT_EQ(dgm_state_create(asset, 0, nullptr, nullptr, &state, nullptr), DGM_OK);
    dgm_physics_options options{};
    options.struct_size = sizeof options;
    options.metres_per_unit = 1e-3;
    options.dt = kDt;
    options.viscosity = 2e-3f;
    dgm_physics* physics = nullptr;
    ASSERT_EQ(dgm_physics_create(state, &options, nullptr, &physics, nullptr), DGM_OK);
    dgm_compliance* compliance = nullptr;
    ASSERT_EQ(dgm_compliance_create(state, physics, nullptr, nullptr, &compliance, nullptr), DGM_OK);
    dgm_compliance_reader* reader = nullptr;
    ASSERT_EQ(dgm_compliance_reader_create(compliance, nullptr, nullptr, &reader, nullptr), DGM_OK);
    Pressed same(25);
    dgm_step_options how{};
    how.struct_size = sizeof how;
    how.cycles = 5;
    how.tool_radius = kRadius;
    dgm_tool_input tool{};
    tool.struct_size = sizeof tool;
    for (int k = 0; k < 25; ++k) {
        const float share = std::min(1.0f, kDt * static_cast<float>(k) / 0.1f);
        tool.position[0] = 5;
        tool.position[1] = 3;
        tool.position[2] = 65 - 8 * share;
        ASSERT_EQ(dgm_physics_step(state, physics, &how, &tool, 1, nullptr, nullptr, nullptr), DGM_OK);
        dgm_compliance_report report{};
        report.struct_size = sizeof report;
        ASSERT_EQ(dgm_compliance_publish(compliance, state, physics, &how, &tool, 1, &report, nullptr), DGM_OK);
        EXPECT_EQ(report.frame, std::uint64_t(k) + 1);
    }
    tool.position[2] -= 1;
    dgm_compliance_answer answer{};
    answer.struct_size = sizeof answer;
    ASSERT_EQ(dgm_compliance_tick(reader, &tool, 1, &answer, nullptr), DGM_OK);
    const Vec3 wanted = same.feel({0, 0, -1});
    EXPECT_EQ(answer.force[0], wanted.x);
    EXPECT_EQ(answer.force[1], wanted.y);
    EXPECT_EQ(answer.force[2], wanted.z);
    EXPECT_EQ(answer.frame, 25u);
    EXPECT_EQ(dgm_compliance_tick(reader, nullptr, 1, &answer, nullptr), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_compliance_create(nullptr, physics, nullptr, nullptr, &compliance, nullptr), DGM_BAD_ARGUMENT);
    dgm_compliance_reader_destroy(reader);
    dgm_compliance_destroy(compliance);
    dgm_physics_destroy(physics);
    dgm_state_destroy(state);
    dgm_asset_close(asset);
}

}  // namespace
}  // namespace dgm::test
