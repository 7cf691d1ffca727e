// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/physics_factor_test.cpp
// Steps that are preconditioned with factors of the second derivatives at rest: near the converged step after few
// cycles, symmetric, the same bits, within their limits. Looks inside the library.
#include <dgm/dgm_physics.h>
#include <gtest/gtest.h>

#include <random>

#include "physics/physics_impl.h"
#include "physics_shapes.h"

namespace dgm::test {
namespace {

using detail::PhysicsImpl;
using detail::physics::Field;

PhysicsOptions with_factors(bool plain = false) {
    PhysicsOptions o{.material = Material{}};
    o.metres_per_unit = 1e-3;
    o.solver = Solver::Factors;
    o.plain_loops = plain;
    return o;
}
struct Shape {
    const char* name;
    ChartSpec chart;
};
std::vector<Shape> shapes() {
    ChartSpec mixed = organ_chart(33);
    add_mixed_diagonals(mixed);
    return {{"organ", std::move(mixed)}, {"torus", torus_chart(33)}, {"tree", tree_chart(33)}};
}

/// A ball goes into the top of a body.
struct Pressed {
    Body body;
    Vec3 top;
    StepTool answer;
    explicit Pressed(const ChartSpec& chart, bool plain = false) : body(chart, with_factors(plain), plain) {
        const PointView rest = body.state.rest_positions();
        top = rest[0];
        for (std::uint32_t k = 0; k < rest.count; ++k)
            if (rest[k].z > top.z) top = rest[k];
    }
    StepReport go(int k, std::uint32_t cycles) {
        ToolInput ball;
        ball.position = top + Vec3{0, 0, 15 - 0.1f * float(k)};
        StepOptions o;
        o.cycles = cycles;
        o.tool_radius = 15;
        return step(body.state, body.physics, o, {&ball, 1}, {&answer, 1}).value();
    }
    std::vector<Vec3> points() const {
        std::vector<Vec3> out;
        const PointView now = body.state.positions();
        for (std::uint32_t k = 0; k < now.count; ++k) out.push_back(now[k]);
        return out;
    }
};
double size(Vec3 v) {
    return std::sqrt(double{dot(v, v)});
}
double distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += double{dot(a[k] - b[k], a[k] - b[k])};
    return std::sqrt(sum);
}

/// At the first touch, where multigrid leaves 0.03 to 0.05 after two cycles, and in the midst of a press.
TEST(PhysicsFactors, TwoCyclesComeWithinOnePercentOfTheConvergedStep) {
    for (const Shape& shape : shapes())
        for (const int steps : {1, 20, 60}) {
            SCOPED_TRACE(testing::Message() << shape.name << ", after " << steps << " steps");
            std::vector<Vec3> after[2], before;
            Vec3 force[2];
            for (const int way : {0, 1}) {
                Pressed p(shape.chart);
                for (int k = 1; k < steps; ++k) p.go(k, 3);
                before = p.points();
                const StepReport r = p.go(steps, way == 0 ? 200 : 2);
                EXPECT_GT(r.contacts, 0u);
                EXPECT_LE(std::fabs(r.volume_error), 1e-8);
                after[way] = p.points();
                force[way] = p.answer.force;
            }
            EXPECT_LE(distance(after[1], after[0]), 0.01 * distance(before, after[0]));
            EXPECT_LE(size(force[1] - force[0]), 0.01 * size(force[0]));
        }
}

void fill(const PhysicsImpl& p, const Field& f, std::mt19937& random) {
    for (float* plane : f.p)
        for (std::uint32_t d = 0; d < p.fine().dofs; ++d) plane[p.fine().sample_of[d]] = float(random() % 1000) - 500;
    detail::physics::share_copies(p.fine(), f);
}

TEST(PhysicsFactors, TheInverseIsSymmetricAndPositive) {
    for (const Shape& shape : shapes()) {
        Body body(shape.chart, with_factors());
        PhysicsImpl& p = *body.physics.impl();
        ASSERT_TRUE(p.factored());
        std::mt19937 random(7);
        fill(p, p.before, random);
        fill(p, p.last, random);
        const auto inner = [&](const Field& a, const Field& b) {
            return p.solver.kernels->inner(p.fine().count(), p.fine().own, a, b);
        };
        detail::physics::apply_inverse(p, p.way, p.before);
        detail::physics::apply_inverse(p, p.fresh, p.last);
        const double aa = inner(p.before, p.way), bb = inner(p.last, p.fresh);
        EXPECT_GT(aa, 0);
        EXPECT_GT(bb, 0);
        EXPECT_NEAR(inner(p.before, p.fresh), inner(p.last, p.way), 1e-4 * std::sqrt(aa * bb)) << shape.name;
    }
}

/// The factors are those of the body at rest: they turn with it.
TEST(PhysicsFactors, TurnWithTheBody) {
    Body body(organ_chart(25), with_factors());
    PhysicsImpl& p = *body.physics.impl();
    const double q[9] = {0.6, -0.8, 0, 0.224, 0.168, -0.96, 0.768, 0.576, 0.28};
    for (std::uint32_t s = 0; s < p.total; ++s)
        for (std::size_t a = 0; a < 3; ++a) {
            double to = 0;
            for (std::size_t b = 0; b < 3; ++b) to += q[3 * a + b] * double{p.rest.p[b][s]};
            p.delta.p[a][s] = static_cast<float>(to - double{p.rest.p[a][s]});
        }
    (void)detail::physics::evaluate(p);
    detail::physics::fit_turn(p);
    for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(p.factor.turn[k], q[k], 1e-4) << k;
}

TEST(PhysicsFactors, PlainLoopsGiveTheSameBits) {
    for (const Shape& shape : shapes()) {
        Pressed one(shape.chart), other(shape.chart, true);
        for (int k = 1; k < 30; ++k) {
            const StepReport a = one.go(k, 2), b = other.go(k, 2);
            ASSERT_EQ(a.elastic, b.elastic) << shape.name << ", step " << k;
            ASSERT_EQ(a.residual, b.residual) << shape.name << ", step " << k;
            ASSERT_TRUE(one.answer.force == other.answer.force) << shape.name << ", step " << k;
        }
        ASSERT_EQ(distance(one.points(), other.points()), 0) << shape.name;
    }
}

TEST(PhysicsFactors, AreForTheStepTheyWereMadeWithAndFewHeldSamples) {
    Pressed p(organ_chart(17));
    PhysicsImpl& impl = *p.body.physics.impl();
    p.go(1, 2);
    EXPECT_TRUE(impl.factored());
    ASSERT_TRUE(p.body.physics.set_dt(1e-2f).ok());
    p.go(2, 2);
    EXPECT_FALSE(impl.factored());
    ASSERT_TRUE(p.body.physics.set_dt(1e-3f).ok());
    p.go(3, 2);
    EXPECT_TRUE(impl.factored());
    const Pin pin{0, p.body.state.positions()[0]};
    StepOptions pinned;
    pinned.pins = {&pin, 1};
    ASSERT_TRUE(step(p.body.state, p.body.physics, pinned).ok());
    EXPECT_FALSE(impl.factored());
    Obstacle lid;
    lid.point = p.top - Vec3{0, 0, 40};
    lid.normal = {0, 0, -1};
    StepOptions pressed;
    pressed.obstacles = {&lid, 1};
    EXPECT_GT(step(p.body.state, p.body.physics, pressed).value().contacts, 17u * 17u / 16);
    EXPECT_FALSE(impl.factored());
}

TEST(PhysicsFactors, AreRefusedBeyondTheirLimits) {
    const State large = make_state(organ_chart(131)), small = make_state(organ_chart(17));
    EXPECT_EQ(Physics::create(large, with_factors()).error().code, ErrorCode::LimitExceeded);
    PhysicsOptions o = with_factors();
    o.solver = Solver::Multigrid;
    o.max_bytes = 2'000'000;
    EXPECT_TRUE(Physics::create(small, o).ok());
    o.solver = Solver::Factors;
    EXPECT_EQ(Physics::create(small, o).error().code, ErrorCode::LimitExceeded);
    o = with_factors();
    o.solver = Solver{2};
    EXPECT_EQ(Physics::create(small, o).error().code, ErrorCode::BadArgument);
}

TEST(PhysicsFactors, TakeNoMoreMemoryThanTheLimit) {
    for (const ChartSpec& chart :
         {organ_chart(9), organ_chart(33), torus_chart(33), grid_chart(65, 17, [](double i, double j) {
              return Point{float(i), float(j), 0};
          })}) {
        const State state = make_state(chart);
        CountedMemory use;
        PhysicsOptions o = with_factors();
        o.allocator = use.allocator();
        ASSERT_TRUE(Physics::create(state, o).ok());
        EXPECT_EQ(use.now, 0u);
        o.max_bytes = use.most - 1;
        EXPECT_EQ(Physics::create(state, o).error().code, ErrorCode::LimitExceeded);
        o.max_bytes = use.most + use.most / 2;
        EXPECT_TRUE(Physics::create(state, o).ok());
    }
}

/// Energy that nothing brings in does not rise: the ball has gone.
TEST(PhysicsFactors, EnergyFallsOnceTheBallHasGone) {
    for (const std::uint32_t cycles : {1u, 2u}) {
        Pressed p(organ_chart(33));
        for (int k = 1; k < 60; ++k) p.go(k, cycles);
        double last = 0, first = 0;
        StepOptions o;
        o.cycles = cycles;
        for (int k = 0; k < 300; ++k) {
            const StepReport r = step(p.body.state, p.body.physics, o).value();
            const double now = r.kinetic + r.elastic;
            if (k == 0)
                first = now;
            else
                ASSERT_LE(now, last + 1e-6 * first) << "step " << k << ", cycles " << cycles;
            last = now;
        }
        EXPECT_LT(last, 0.9 * first);
    }
}

}  // namespace
}  // namespace dgm::test
