// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/physics_energy_test.cpp
// Bodies that nothing pushes: kinetic, elastic and potential energy together never rise, however few cycles a step has.
#include <gtest/gtest.h>

#include <random>

#include "physics/physics_impl.h"
#include "physics_shapes.h"

namespace dgm::test {
namespace {
using detail::PhysicsImpl;

/// Quads as long and sheared as those of maps with slow convergence.
ChartSpec flat_organ_chart(std::uint32_t side) {
    return closed_chart(side, [](std::array<double, 3> n) {
        return std::array<double, 3>{75 * n[0] + 30 * n[2], 12 * n[1] * (1 + 0.4 * n[0]), 15 * n[2]};
    });
}
ChartSpec long_sheet_chart() {
    ChartSpec chart = grid_chart(25, 33, [](double i, double j) {
        return Point{float(4 * i + 2 * j), float(0.4 * j), float(3 * std::sin(0.2 * i))};
    });
    add_mixed_diagonals(chart);
    return chart;
}
struct Shape {
    const char* name;
    ChartSpec chart;
};
std::vector<Shape> shapes() {
    return {{"organ", organ_chart(33)}, {"flat organ", flat_organ_chart(33)},      {"torus", torus_chart(33)},
            {"tree", tree_chart(33)},   {"fine flat organ", flat_organ_chart(65)}, {"sheet", long_sheet_chart()}};
}

/// What evaluate() finds for the shape as it is, whatever the search thought of it, and the kinetic energy.
double energy_in_place(PhysicsImpl& p, const StepReport& report) {
    for (float* f : p.delta.p) std::fill(f, f + p.fine().count(), 0.0f);
    return detail::physics::evaluate(p).elastic + report.kinetic;
}
double height_energy(const PhysicsImpl& p, Vec3 gravity) {
    double sum = 0;
    const float g[3] = {gravity.x, gravity.y, gravity.z};
    for (int c = 0; c < 3; ++c)
        for (std::uint32_t k = 0; k < p.total; ++k)
            sum -= double{p.fine().own[k]} * double{p.mass[k]} * double{g[c]} * p.at[c][k];
    return sum;
}

struct Case {
    float dt;
    std::uint32_t cycles;
    float viscosity;
    float foundation;
};
class Energy : public testing::TestWithParam<Case> {};

/// A ball goes down through samples picked by chance, and is gone. What reports say never rises, and what evaluate()
/// finds is never above the report before, but for rounding.
TEST_P(Energy, NeverRisesOnceTheBallHasGone) {
    const Case c = GetParam();
    for (const Shape& shape : shapes()) {
        SCOPED_TRACE(shape.name);
        PhysicsOptions options{.material = Material{200, 0.3f, 1e-3f, c.foundation, 5, c.viscosity}};
        options.dt = c.dt;
        Body body(shape.chart, options);
        PhysicsImpl& p = *body.physics.impl();
        StepOptions how;
        how.cycles = c.cycles;
        how.tool_radius = 10;
        std::mt19937 random(5);
        bool moved = false;
        for (int touch = 0; touch < 3; ++touch) {
            ToolInput ball;
            const Vec3 at = body.state.positions()[random() % p.total];
            double last = 0;
            for (int k = 0; k < 20; ++k) {
                ball.position = at + Vec3{0, 0, float(11 - 0.4 * k)};
                const StepReport r = step(body.state, body.physics, how, {&ball, 1}).value();
                last = r.kinetic + r.elastic;
            }
            const double first = last;
            moved = moved || first > 1e-6;
            for (int k = 0; k < 80; ++k) {
                const StepReport r = step(body.state, body.physics, how).value();
                const double in_place = energy_in_place(p, r), now = r.kinetic + r.elastic;
                ASSERT_LE(now, last + 1e-6 * first) << "touch " << touch << ", step " << k;
                ASSERT_LE(in_place, last * (1 + 1e-4) + 1e-6 * first) << "touch " << touch << ", step " << k;
                last = now;
            }
        }
        EXPECT_TRUE(moved);
    }
}
INSTANTIATE_TEST_SUITE_P(Settings, Energy,
                         testing::Values(Case{1e-4f, 3, 0, 2e4f}, Case{1e-3f, 1, 0, 2e4f}, Case{1e-3f, 3, 0, 0},
                                         Case{1e-2f, 1, 0, 0}, Case{1e-2f, 2, 0, 0}, Case{1e-2f, 3, 0, 2e4f},
                                         Case{1.0f / 60, 4, 2e-3f, 2e4f}));

TEST(EnergyInWeight, NeverRisesWhileASheetSwings) {
    // Held at two corners, it falls and swings to and fro: what it loses in height is all that it may gain.
    for (const std::uint32_t cycles : {1u, 3u}) {
        PhysicsOptions options{.material = Material{500, 0.2f, 1e-5f, 0, 0.2f, 0}};
        options.dt = 2e-3f;
        Body body(grid_chart(33, 33,
                             [](double i, double j) {
                                 return Point{float(10 * i), float(10 * j), 0};
                             }),
                  options);
        PhysicsImpl& p = *body.physics.impl();
        const PointView rest = body.state.rest_positions();
        const Pin pins[] = {{0, rest[0]}, {32, rest[32]}};
        StepOptions how;
        how.cycles = cycles;
        how.gravity = {0, 0, -9.81f};
        how.pins = pins;
        double last = 0, deepest = 0;
        for (int k = 0; k < 400; ++k) {
            const StepReport r = step(body.state, body.physics, how).value();
            const double height = height_energy(p, how.gravity), now = r.kinetic + r.elastic + height;
            deepest = std::min(deepest, height);
            EXPECT_LE(now, last - 1e-6 * deepest) << "step " << k << ", cycles " << cycles;
            last = now;
        }
        EXPECT_LT(deepest, -0.01) << "J: it fell";
    }
}

/// What a body on a table does with its energy: kinetic, elastic and that of its height.
struct Fallen {
    double first = 0, last = 0;  ///< J; first: the way that it may fall
    double rise = 0, rises = 0;  ///< the largest in a step, and all of them
    std::uint32_t contacts = 0;  ///< at most
    double speed = 0;            ///< m/s, root mean square at the end
    double lowest = 0;           ///< J, after converged steps of 10 ms more
};
/// An ellipsoid that is 8 mm above a table, or two, or a ball that stands still.
Fallen fall(const ChartSpec& chart, float dt, std::uint32_t cycles, std::span<const Obstacle> obstacles, int steps,
            float friction = 0, int more = 0) {
    PhysicsOptions options{.material = Material{200, 0.3f, 1e-3f, 0, 5, 0}};
    options.dt = dt;
    Body body(chart, options);
    PhysicsImpl& p = *body.physics.impl();
    StepOptions how;
    how.cycles = cycles;
    how.gravity = {0, 0, -9.81f};
    how.obstacles = obstacles;
    how.friction = friction;
    Fallen out;
    double mass = 0, kinetic = 0;
    for (std::uint32_t k = 0; k < p.total; ++k) mass += double{p.fine().own[k]} * double{p.mass[k]};
    out.first = mass * 9.81 * 8e-3;
    for (int k = 0; k < steps; ++k) {
        const StepReport r = step(body.state, body.physics, how).value();
        const double now = r.kinetic + r.elastic + height_energy(p, how.gravity), rise = now - out.last;
        EXPECT_FALSE(r.clamped);
        out.rise = std::max(out.rise, rise);
        out.rises += std::max(0.0, rise);
        out.last = now;
        out.contacts = std::max(out.contacts, r.contacts);
        kinetic = r.kinetic;
    }
    out.speed = std::sqrt(2 * kinetic / mass);
    EXPECT_TRUE(body.physics.set_dt(1e-2f).ok());
    how.cycles = 100;
    for (int k = 0; k < more; ++k) {
        const StepReport r = step(body.state, body.physics, how).value();
        out.lowest = r.kinetic + r.elastic + height_energy(p, how.gravity);
    }
    return out;
}
Obstacle plane_at(Vec3 point, Vec3 normal) {
    Obstacle o;
    o.kind = ObstacleKind::Plane;
    o.point = point;
    o.normal = normal;
    return o;
}
/// A table below the body's lowest point, -50; a trough of two planes; a ball.
std::vector<std::vector<Obstacle>> tables() {
    Obstacle ball;
    ball.kind = ObstacleKind::Sphere;
    ball.point = {0, 0, -258};
    ball.radius = 200;
    return {{plane_at({0, 0, -58}, {0, 0, 1})},
            {plane_at({0, 0, -98}, {0.6f, 0, 0.8f}), plane_at({0, 0, -98}, {-0.6f, 0, 0.8f})},
            {ball}};
}

/// Obstacles that stand still do no work, however few cycles a step has. Without the guards a body gains all of its
/// fall anew, and with one cycle a step three times that.
TEST(EnergyInContact, NeverRisesWhileABodyFallsOnWhatStandsStill) {
    struct Setting {
        float dt;
        std::uint32_t cycles;
        int steps;
    };
    for (const Setting& s : {Setting{1e-3f, 3, 1500}, Setting{1e-3f, 1, 1500}, Setting{1e-2f, 2, 300}}) {
        int number = 0;
        for (const auto& obstacles : tables()) {
            SCOPED_TRACE(testing::Message() << "table " << number++ << ", dt " << s.dt << ", cycles " << s.cycles);
            for (const float friction : {0.0f, 0.5f}) {
                const Fallen f = fall(organ_chart(17), s.dt, s.cycles, obstacles, s.steps, friction);
                EXPECT_LE(f.rise, 1e-6 * f.first) << "energies are summed from floats; friction " << friction;
                EXPECT_LE(f.rises, 1e-5 * f.first) << friction;
                EXPECT_LT(f.last, -0.5 * f.first) << "it fell; " << friction;
                EXPECT_GT(f.contacts, 10u) << friction;
            }
        }
    }
}

void lies_on_a_table(int steps) {
    const auto obstacles = tables();
    const Fallen f = fall(organ_chart(9), 1e-3f, 3, obstacles.front(), steps, 0, 200);
    EXPECT_LE(f.rise, 1e-7 * f.first);
    EXPECT_LE(f.rises, 1e-6 * f.first);
    EXPECT_LT(f.speed, 1e-5) << "it lies still";
    EXPECT_NEAR(f.last, f.lowest, 1e-4 * f.first) << "in equilibrium";
}
TEST(EnergyInContact, AHundredThousandStepsOnATable) {
    lies_on_a_table(100'000);
}
/// Takes three minutes: dgm_physics_tests --gtest_also_run_disabled_tests --gtest_filter='*Million*'
TEST(EnergyInContact, DISABLED_AMillionStepsOnATable) {
    lies_on_a_table(1'000'000);
}

TEST(EnergyInFlight, BodiesThatFlyKeepTheirMomentum) {
    // Thrown by pins, with a body that shakes because one sample was left behind: steps of one cycle need the guard.
    PhysicsOptions options{.material = Material{200, 0.3f, 1e-3f, 0, 5, 0}};
    options.dt = 5e-3f;
    Body body(flat_organ_chart(33), options);
    PhysicsImpl& p = *body.physics.impl();
    const PointView rest = body.state.rest_positions();
    std::vector<Pin> pins;
    for (std::uint32_t k = 0; k < rest.count; ++k) {
        const std::uint32_t id = body.state.class_of(k);
        if (id == kNone || body.state.class_members(id)[0] == k)
            pins.push_back({k, rest[k] + Vec3{float(2 + 0.05 * double(rest[k].y)), 3, -1}});
    }
    StepOptions how;
    how.cycles = 1;
    how.pins = pins;
    ASSERT_TRUE(step(body.state, body.physics, how).ok());
    how.pins = {};
    const auto momentum = [&] {
        std::array<double, 3> sum{};
        for (std::size_t c = 0; c < 3; ++c)
            for (std::uint32_t k = 0; k < p.total; ++k)
                sum[c] += double{p.fine().own[k]} * double{p.mass[k]} * double{p.velocity.p[c][k]};
        return sum;
    };
    const auto first = momentum();
    double last = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 300; ++k) {
        const StepReport r = step(body.state, body.physics, how).value();
        EXPECT_LE(r.kinetic + r.elastic, last * (1 + 1e-6)) << k;
        last = r.kinetic + r.elastic;
    }
    const auto now = momentum();
    const double whole = std::hypot(first[0], first[1], first[2]);
    EXPECT_GT(whole, 0);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(now[c], first[c], 0.01 * whole) << c;
}

}  // namespace
}  // namespace dgm::test
