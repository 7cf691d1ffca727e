// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/physics_friction_test.cpp
// Friction of bodies against what Coulomb's law says of blocks on slopes, balls that roll and tools that hold.
#include <gtest/gtest.h>

#include <cstring>
#include <numbers>
#include <vector>

#include "physics/physics_impl.h"
#include "physics_shapes.h"

namespace dgm::test {
namespace {

using detail::Double3;
using detail::widen;

constexpr double kG = 9.81;
constexpr float kStep = 1e-3f;

/// Of the samples' masses.
struct Motion {
    double mass = 0;
    Double3 place, speed, turning;  ///< metres, m/s; momentum of turning around the middle, kg m^2/s
};
Motion motion_of(const Body& body) {
    const detail::PhysicsImpl& p = *body.physics.impl();
    const PointView x = body.state.positions();
    Motion m;
    const auto each = [&](auto f) {
        for (std::uint32_t k = 0; k < p.total; ++k)
            f(double{p.fine().own[k]} * double{p.mass[k]}, p.scale * widen(x[k]),
              Double3{double{p.velocity.p[0][k]}, double{p.velocity.p[1][k]}, double{p.velocity.p[2][k]}});
    };
    each([&](double mass, Double3 at, Double3 v) {
        m.mass += mass;
        m.place = m.place + mass * at;
        m.speed = m.speed + mass * v;
    });
    m.place = (1 / m.mass) * m.place;
    m.speed = (1 / m.mass) * m.speed;
    each([&](double mass, Double3 at, Double3 v) { m.turning = m.turning + mass * cross(at - m.place, v - m.speed); });
    return m;
}
/// A table at a slope, seen from the table.
Vec3 down_slope(double slope) {
    const double c = 1 / std::sqrt(1 + slope * slope);
    return {float(kG * slope * c), 0, float(-kG * c)};
}
Obstacle table(float height) {
    return {.kind = ObstacleKind::Plane, .point = {0, 0, height}, .normal = {0, 0, 1}};
}
PhysicsOptions loose(float membrane, float bending) {
    PhysicsOptions options{.material = Material{membrane, 0.3f, bending, 0, 5, 0}};
    options.dt = kStep;
    return options;
}
StepOptions with(double friction, Vec3 gravity = {}, std::span<const Obstacle> obstacles = {},
                 std::uint32_t cycles = 3) {
    StepOptions how;
    how.cycles = cycles;
    how.gravity = gravity;
    how.obstacles = obstacles;
    how.friction = float(friction);
    return how;
}
Body flat_sheet() {
    return Body(grid_chart(9, 9,
                           [](double i, double j) {
                               return Point{float(10 * i), float(10 * j), 0};
                           }),
                loose(500, 1e-2f));
}

TEST(PhysicsFriction, HoldsASheetBelowItsAngleAndLetsItSlideBeyond) {
    for (const auto& [slope, friction] : {std::pair{0.28, 0.3}, std::pair{0.5, 0.3}, std::pair{0.35, 0.3}}) {
        SCOPED_TRACE(slope);
        Body body = flat_sheet();
        const Obstacle under[] = {table(0)};
        const StepOptions how = with(friction, down_slope(slope), under);
        const auto settle = [&](int steps) {
            for (int k = 0; k < steps; ++k) (void)step(body.state, body.physics, how).value();
        };
        settle(100);
        const Motion first = motion_of(body);
        settle(400);
        const Motion last = motion_of(body);
        const double exact = kG / std::sqrt(1 + slope * slope) * (slope - friction);
        if (slope < friction)
            EXPECT_LT(std::fabs(last.place.x - first.place.x), 1e-5);
        else
            EXPECT_NEAR((last.speed.x - first.speed.x) / 0.4, exact, 0.01 * exact);
    }
}

TEST(PhysicsFriction, StopsASheetThatSlidesAndGivesBackNothing) {
    constexpr double kFriction = 0.4, kSpeed = 0.5;
    Body body = flat_sheet();
    detail::PhysicsImpl& p = *body.physics.impl();
    const Obstacle under[] = {table(0)};
    StepOptions how = with(0, down_slope(0), under);
    for (int k = 0; k < 50; ++k) (void)step(body.state, body.physics, how).value();  // lies down
    std::fill(p.velocity.p[0], p.velocity.p[0] + p.total, float(kSpeed));
    how.friction = float(kFriction);
    const double start = motion_of(body).place.x;
    double last = 0.5 * motion_of(body).mass * kSpeed * kSpeed;
    const double first = last;
    for (int k = 0; k < 300; ++k) {
        const StepReport r = step(body.state, body.physics, how).value();
        const double now = r.kinetic + r.elastic + motion_of(body).mass * kG * motion_of(body).place.z;
        EXPECT_LE(now, last + 1e-6 * first) << k;
        last = now;
    }
    const double exact = kSpeed * kSpeed / (2 * kFriction * kG);
    EXPECT_NEAR(motion_of(body).place.x - start, exact, 0.01 * exact);
    EXPECT_LT(std::fabs(motion_of(body).speed.x), 1e-5);
}

TEST(PhysicsFriction, TakesASheetAlongWithItsTable) {
    // A table that starts at `pull`: what is on it comes along while friction can do that, and else gains mu g.
    constexpr double kFriction = 0.3, kTime = 0.3;
    for (const double pull : {1.5, 6.0}) {
        SCOPED_TRACE(pull);
        Body body = flat_sheet();
        Obstacle under[] = {table(0)};
        const StepOptions how = with(kFriction, down_slope(0), under);
        for (int k = 0; k < 100; ++k) (void)step(body.state, body.physics, how).value();  // lies down
        const double scale = body.physics.impl()->scale, start = motion_of(body).place.x;
        const int steps = static_cast<int>(kTime / double{kStep});
        for (int k = 1; k <= steps; ++k) {
            const double t = k * double{kStep};
            under[0].point.x = float(0.5 * pull * t * t / scale);
            (void)step(body.state, body.physics, how).value();
        }
        const double gained = std::min(pull, kFriction * kG);
        EXPECT_NEAR(motion_of(body).speed.x, gained * kTime, 0.02 * gained * kTime);
        EXPECT_NEAR(motion_of(body).place.x - start, 0.5 * gained * kTime * kTime, 0.03 * gained * kTime * kTime);
    }
}

TEST(PhysicsFriction, TakesASheetAlongWithASkinThatIsKnownAsItWas) {
    // The samples of the skin move, its frame stays.
    constexpr double kFriction = 0.3, kTime = 0.3, kPull = 1.5;
    for (const bool known : {true, false}) {
        SCOPED_TRACE(known);
        Body body = flat_sheet();
        State skin = make_state(grid_chart(17, 17, [](double i, double j) {
            return Point{float(20 * i - 110), float(20 * j - 110), 0};
        }));
        Obstacle under[] = {{.kind = ObstacleKind::Surface, .surface = &skin}};
        const StepOptions how = with(kFriction, down_slope(0), under);
        for (int k = 0; k < 100; ++k) (void)step(body.state, body.physics, how).value();  // lies down
        const double scale = body.physics.impl()->scale, start = motion_of(body).place.x;
        detail::StateImpl& s = *skin.impl();
        const std::vector<float> rest(s.now.x, s.now.x + skin.sample_count());
        std::vector<float> was = rest;
        if (known) under[0].before = {was.data(), s.now.y, s.now.z, was.size(), 1};
        const int steps = static_cast<int>(kTime / double{kStep});
        for (int k = 1; k <= steps; ++k) {
            const double t = k * double{kStep};
            std::copy_n(s.now.x, was.size(), was.begin());
            for (std::size_t n = 0; n < was.size(); ++n) s.now.x[n] = rest[n] + float(0.5 * kPull * t * t / scale);
            s.touch_all();
            (void)step(body.state, body.physics, how).value();
        }
        const double gained = known ? kPull : 0, tolerance = 0.03 * kPull * kTime;
        EXPECT_NEAR(motion_of(body).speed.x, gained * kTime, tolerance);
        EXPECT_NEAR(motion_of(body).place.x - start, 0.5 * gained * kTime * kTime, tolerance * kTime);
    }
}

/// How far a cap comes along in 0.3 s on a faceted ball of 0.3 m whose samples turn by 0.15 rad, faster and faster.
/// @param upright  about the z axis; else about the x axis
/// @param seams    it lies where four seams meet; else where none is
double turned_along(bool upright, bool seams) {
    Body body(grid_chart(17, 17,
                         [](double i, double j) {
                             const double x = 12.5 * (i - 8), y = 12.5 * (j - 8);
                             return Point{float(x), float(y), float(std::sqrt(300.5 * 300.5 - x * x - y * y))};
                         }),
              loose(500, 1e-2f));
    const double way = seams ? -300 : 300;
    State skin = make_state(closed_chart(33, [=](std::array<double, 3> n) {
        return std::array<double, 3>{300 * n[0], way * n[1], way * n[2]};
    }));
    Obstacle under[] = {{.kind = ObstacleKind::Surface, .surface = &skin}};
    const StepOptions how = with(1, down_slope(0), under);
    for (int k = 0; k < 200; ++k) (void)step(body.state, body.physics, how).value();  // lies down
    const auto angle = [&] {
        const PointView x = body.state.positions();
        const Vec3 across = x[12 * 17 + 8] - x[4 * 17 + 8], middle = x[8 * 17 + 8];
        return upright ? std::atan2(double{across.y}, double{across.x})
                       : std::atan2(-double{middle.y}, double{middle.z});
    };
    const double start = angle();
    detail::StateImpl& s = *skin.impl();
    float* const now[3] = {s.now.x, s.now.y, s.now.z};
    std::vector<float> rest[3], was[3];
    for (int d = 0; d < 3; ++d) rest[d].assign(now[d], now[d] + skin.sample_count());
    for (int k = 1; k <= 300; ++k) {
        for (int d = 0; d < 3; ++d) was[d].assign(now[d], now[d] + skin.sample_count());
        under[0].before = {was[0].data(), was[1].data(), was[2].data(), was[0].size(), 1};
        const double by = 0.15 * k * k / 9e4, c = std::cos(by), n = std::sin(by);
        const int a = upright ? 0 : 1;
        for (std::size_t i = 0; i < was[0].size(); ++i) {
            const double x = double{rest[a][i]}, y = double{rest[a + 1][i]};
            now[a][i] = float(c * x - n * y);
            now[a + 1][i] = float(n * x + c * y);
        }
        s.touch_all();
        (void)step(body.state, body.physics, how).value();
    }
    return angle() - start;
}
TEST(PhysicsFriction, TurnsACapAlongWithACurvedSkin) {
    for (const bool upright : {true, false})
        for (const bool seams : {true, false})
            EXPECT_NEAR(turned_along(upright, seams), 0.15, 1e-4) << upright << seams;
}

TEST(PhysicsFriction, MakesAHollowBallRoll) {
    // Without sliding 0.6 of what it would slide with [2/3 m r^2 of a shell]; with less friction than 0.4 of the slope
    // it slides, and turns as friction makes it.
    constexpr double kSlope = 0.3, kRadius = 0.05, kTime = 0.3;
    for (const double friction : {0.6, 0.05}) {
        SCOPED_TRACE(friction);
        PhysicsOptions options = loose(20000, 1e-2f);
        options.metres_per_unit = kRadius;
        Body body(sphere_chart(33), options);
        const Obstacle under[] = {table(-1)};
        const StepOptions how = with(friction, down_slope(kSlope), under, 20);
        for (int k = 0; k < 300; ++k) (void)step(body.state, body.physics, how).value();
        const Motion last = motion_of(body);
        const double down = kG / std::sqrt(1 + kSlope * kSlope);
        const bool rolls = friction > 0.4 * kSlope;
        const double exact = kTime * down * (rolls ? 0.6 * kSlope : kSlope - friction);
        const double exact_turns = rolls ? exact / kRadius : kTime * down * 1.5 * friction / kRadius;
        EXPECT_NEAR(last.speed.x, exact, 0.015 * exact);
        EXPECT_NEAR(last.turning.y / (2.0 / 3 * last.mass * kRadius * kRadius), exact_turns, 0.03 * exact_turns);
    }
}

/// Two balls press on a body from both sides, go up by 30 mm and stop.
struct Lifted {
    double height = 0;        ///< that the body goes up on the second half of their way, metres
    Double3 force;            ///< N, on both tools at the end
    double weight = 0;        ///< N
    std::vector<Vec3> shape;  ///< at the end
};
Lifted lift(float friction, float layer, int steps = 1200, bool plain = false) {
    Body body(organ_chart(33), loose(2000, 1e-2f), plain);
    const Obstacle under[] = {table(-50)};
    StepOptions how = with(double{friction}, down_slope(0), under);
    how.tool_radius = 15;
    how.tool_layer = layer;
    Lifted out;
    StepTool answers[2];
    for (int k = 0; k < steps; ++k) {
        const auto in = float(0.1 * std::min(k, 280)), up = float(0.1 * std::clamp(k - 300, 0, 300));
        const ToolInput jaws[] = {{.tool = 0, .position = {0, 76 - in, up}}, {.tool = 1, .position = {0, in - 76, up}}};
        (void)step(body.state, body.physics, how, jaws, answers).value();
        if (k == 450 || k == 600) out.height = motion_of(body).place.z - out.height;
    }
    out.weight = motion_of(body).mass * kG;
    for (const StepTool& a : answers) out.force = out.force + widen(a.force);
    for (std::uint32_t k = 0; k < body.physics.impl()->total; ++k) out.shape.push_back(body.state.positions()[k]);
    return out;
}

TEST(PhysicsFriction, HoldsABodyBetweenTwoTools) {
    const Lifted held = lift(0.8f, 0);
    EXPECT_NEAR(held.height, 0.015, 5e-4);
    EXPECT_NEAR(held.force.z, -held.weight, 0.01 * held.weight);
    EXPECT_NEAR(lift(0.8f, 1e7f, 601).height, 0.015, 1e-3) << "by way of a soft layer";
    EXPECT_LT(lift(0, 0, 601).height, 1e-3) << "slips";
}

TEST(PhysicsFriction, HasTheSameBits) {
    const Lifted once = lift(0.8f, 0, 400), again = lift(0.8f, 0, 400), plain = lift(0.8f, 0, 400, true);
    const std::size_t bytes = once.shape.size() * sizeof(Vec3);
    EXPECT_EQ(std::memcmp(once.shape.data(), again.shape.data(), bytes), 0);
    EXPECT_EQ(std::memcmp(once.shape.data(), plain.shape.data(), bytes), 0);
}

TEST(PhysicsFriction, PullsAToolThatSlidesWithTheCoefficientTimesItsForce) {
    // Over a sheet on a soft bed: the ball goes along, and the force along is mu times the force across.
    constexpr double kFriction = 0.3;
    for (const float layer : {0.0f, 1e6f}) {
        SCOPED_TRACE(layer);
        PhysicsOptions options{.material = Material{500, 0.3f, 1e-3f, 1e5f, 5, 0}};
        options.dt = kStep;
        Body body(grid_chart(33, 33, [](double i, double j) { return Point{float(4 * i), float(4 * j), 0}; }), options);
        StepOptions how = with(kFriction, {}, {}, 10);
        how.tool_radius = 30;
        how.tool_layer = layer;
        double along = 0, across = 0;
        for (int k = 0; k < 600; ++k) {
            const double down = std::min(0.02 * k, 2.0), way = 0.05 * std::max(k - 150, 0);
            const ToolInput ball{.position = {float(50 + way), 64, float(30 - down)}};
            StepTool answer;
            (void)step(body.state, body.physics, how, {&ball, 1}, {&answer, 1}).value();
            if (k < 300) continue;
            along -= double{answer.force.x};
            across += double{answer.force.z};
        }
        ASSERT_GT(across, 0);
        EXPECT_NEAR(along / across, kFriction, 0.03 * kFriction);
    }
}

TEST(PhysicsFriction, IsRefusedOutOfRange) {
    Body body = flat_sheet();
    for (const double wrong : {-0.1, 101.0, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_EQ(step(body.state, body.physics, with(wrong)).error().code, ErrorCode::BadArgument);
}

}  // namespace
}  // namespace dgm::test
