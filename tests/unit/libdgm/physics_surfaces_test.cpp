// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/physics_surfaces_test.cpp
// What a step sees of surfaces, which it remembers from one to the next, against a search from each sample.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "asked.h"
#include "dice.h"
#include "physics/physics_impl.h"
#include "physics_shapes.h"

namespace dgm::test {
namespace {

using detail::Double3;
using detail::PhysicsImpl;
using detail::StateImpl;

ChartSpec ball_chart(std::uint32_t side, double radius) {
    return closed_chart(side, [=](std::array<double, 3> n) {
        return std::array<double, 3>{radius * n[0], radius * n[1], radius * n[2]};
    });
}
ChartSpec wavy_chart(std::uint32_t side, double width) {
    const double step = width / (side - 1);
    return grid_chart(side, side, [=](double i, double j) {
        const double x = step * i - 0.5 * width, y = step * j - 0.5 * width;
        return Point{float(x), float(y), float(12 * std::sin(0.05 * x) + 9 * std::cos(0.07 * y))};
    });
}
/// Turned about the axis (1, 1, 1) by `angle`.
void turn(Obstacle& o, double angle) {
    const double c = std::cos(angle), s = std::sin(angle) / std::sqrt(3), m = (1 - c) / 3;
    const double r[9] = {c + m, m - s, m + s, m + s, c + m, m - s, m - s, m + s, c + m};
    for (int k = 0; k < 9; ++k) o.rotation[k] = float(r[k]);
}

/// Gaps of all free samples to an obstacle before a step, each by a search of its own; NaN where one is held.
std::vector<double> gaps_to(const Body& body, const Obstacle& obstacle) {
    const PhysicsImpl& p = *body.physics.impl();
    const StateImpl& s = *body.state.impl();
    const detail::Shape shape = detail::make_shape(obstacle).value();
    std::vector<double> out(p.fine().grid, std::nan(""));
    for (std::uint32_t k = 0; k < out.size(); ++k) {
        if (p.fine().own[k] == 0 || p.free[k] == 0) continue;
        const double by = 1 / p.scale;
        const Double3 x{double{s.rest.x[k]} + by * p.at[0][k], double{s.rest.y[k]} + by * p.at[1][k],
                        double{s.rest.z[k]} + by * p.at[2][k]};
        out[k] = p.scale * detail::probe(shape, x).distance;
    }
    return out;
}
/// Those that the last step has seen, NaN where it saw none.
std::vector<double> gaps_seen(const Body& body, std::uint32_t obstacle) {
    const PhysicsImpl& p = *body.physics.impl();
    std::vector<double> out(p.fine().grid, std::nan(""));
    for (std::uint32_t k = 0; k < p.touching_count; ++k) {
        const detail::physics::Touching& t = p.touching[p.touching_now][k];
        if (t.obstacle == detail::Scene::kMost + obstacle) out[t.sample] = t.gap;
    }
    return out;
}
/// @return  how many samples were near
std::size_t expect_all_seen(const Body& body, const std::vector<double>& gaps, std::uint32_t obstacle) {
    const std::vector<double> seen = gaps_seen(body, obstacle);
    const double reach = 2 * body.physics.impl()->scale * double{body.state.impl()->mean_step};
    std::size_t near = 0, wrong = 0;
    for (std::size_t k = 0; k < gaps.size(); ++k) {
        near += gaps[k] < reach ? 1 : 0;
        // Where the body is fast, more may be seen.
        if (gaps[k] < reach || !std::isnan(seen[k])) wrong += seen[k] == gaps[k] ? 0 : 1;
    }
    EXPECT_EQ(wrong, 0u);
    return near;
}

StepOptions beside(std::span<const Obstacle> obstacles, std::uint32_t cycles = 1, float friction = 0) {
    StepOptions how;
    how.cycles = cycles;
    how.obstacles = obstacles;
    how.friction = friction;
    return how;
}

/// Moves a surface about and into a body, and checks each step.
void follow(State& skin, const std::function<void(Obstacle&, int)>& path, std::size_t least_seen) {
    PhysicsOptions options;
    options.dt = 2e-3f;
    Body body(organ_chart(33), options);
    Obstacle obstacle{.kind = ObstacleKind::Surface, .surface = &skin};
    const StepOptions how = beside({&obstacle, 1}, 2, 0.3f);
    std::size_t seen = 0;
    for (int k = 0; k < 160 && !testing::Test::HasFailure(); ++k) {
        SCOPED_TRACE(k);
        path(obstacle, k);
        const std::vector<double> gaps = gaps_to(body, obstacle);
        ASSERT_TRUE(step(body.state, body.physics, how).ok());
        seen += expect_all_seen(body, gaps, 0);
    }
    EXPECT_GT(seen, least_seen);
}

TEST(PhysicsSurfaces, AreSeenWhileTheyComeAndTurn) {
    State ball = make_state(ball_chart(25, 40));
    follow(
        ball,
        [](Obstacle& o, int k) {
            o.point = {float(125 - 0.3 * k), float(10 * std::sin(0.1 * k)), 5};
            turn(o, 0.02 * k);
        },
        2000);
    State sheet = make_state(wavy_chart(25, 200));
    follow(
        sheet,
        [](Obstacle& o, int k) {
            o.point = {0, 0, float(-75 + (k % 80 < 40 ? 0.4 * (k % 80) : 0.4 * (80 - k % 80)))};
            turn(o, 0.004 * k);
        },
        2000);
}

TEST(PhysicsSurfaces, AreSeenWhereTheyStopAndBendAndJump) {
    State ball = make_state(ball_chart(25, 40));
    follow(
        ball,
        [&](Obstacle& o, int k) {
            o.point = {112, 0, float(k / 40 % 2 == 0 ? 0 : 300)};
            if (k < 60) return;
            StateImpl& s = *ball.impl();
            for (std::uint32_t n = 0; n < s.total(); ++n) s.now.x[n] *= 1.002f;
            s.touch_all();
        },
        2000);
}

TEST(PhysicsSurfaces, AreSeenAnewWhereTheirReachChanges) {
    // The body lies in the ball's inside: beyond its reach in the first steps, but not so far that nobody looks.
    State ball = make_state(ball_chart(33, 130));
    Body body(organ_chart(33));
    Obstacle obstacle{.kind = ObstacleKind::Surface, .surface = &ball};
    const StepOptions how = beside({&obstacle, 1});
    for (const float reach : {10.0f, 10.0f, 0.0f, 120.0f, 10.0f}) {
        SCOPED_TRACE(reach);
        obstacle.reach = reach;
        const std::vector<double> gaps = gaps_to(body, obstacle);
        ASSERT_TRUE(step(body.state, body.physics, how).ok());
        EXPECT_EQ(expect_all_seen(body, gaps, 0) > 0, reach != 10.0f);
        body.physics.reset();
    }
}

TEST(PhysicsSurfaces, AreSeenByAnyNumberOfThem) {
    // Beyond the first four, searches have no memory; where one goes, another takes its number.
    State ball = make_state(ball_chart(17, 30));
    Body body(organ_chart(25));
    std::vector<Obstacle> all;
    for (int k = 0; k < 7; ++k) all.push_back({.kind = ObstacleKind::Surface, .surface = &ball});
    std::size_t seen = 0;
    for (int k = 0; k < 60 && !HasFailure(); ++k) {
        SCOPED_TRACE(k);
        if (k == 20) all.erase(all.begin());
        if (k == 40) all.insert(all.begin() + 1, {.kind = ObstacleKind::Plane, .point = {0, 0, -60}});
        for (std::size_t o = 0; o < all.size(); ++o) {
            if (all[o].kind != ObstacleKind::Surface) continue;
            const double angle = 0.9 * double(o) + 0.004 * k;
            all[o].point = {float(105 * std::cos(angle)), float(92 * std::sin(angle)), 3};
        }
        std::vector<std::vector<double>> gaps;
        for (const Obstacle& o : all) gaps.push_back(gaps_to(body, o));
        ASSERT_TRUE(step(body.state, body.physics, beside(all)).ok());
        for (std::uint32_t o = 0; o < all.size(); ++o) seen += expect_all_seen(body, gaps[o], o);
    }
    EXPECT_GT(seen, 2000u);
}

TEST(PhysicsSurfaces, AreNotTakenForOthersThatWereAtTheirPlaceInMemory) {
    State ball = make_state(ball_chart(25, 20));
    Body body(organ_chart(17));
    const Obstacle obstacle{.kind = ObstacleKind::Surface, .point = {150, 0, 0}, .surface = &ball};
    for (const float scale : {1.0f, 1.0f, 3.0f}) {
        StateImpl& s = *ball.impl();
        const std::uint64_t moved = s.moved;
        for (float* const x : {s.now.x, s.now.y, s.now.z})
            for (std::uint32_t n = 0; n < s.total(); ++n) x[n] *= scale;
        s.touch_all();
        s.moved = moved;
        const std::vector<double> gaps = gaps_to(body, obstacle);
        ASSERT_TRUE(step(body.state, body.physics, beside({&obstacle, 1})).ok());
        EXPECT_EQ(expect_all_seen(body, gaps, 0) > 0, scale != 1);
    }
}

TEST(PhysicsSurfaces, AreSeenAfterAStepThatWasRefused) {
    State ball = make_state(ball_chart(25, 40));
    Body body(organ_chart(17));
    std::vector<Obstacle> all(1, {.kind = ObstacleKind::Surface, .point = {112, 0, 0}, .surface = &ball});
    for (int k = 0; k < 3; ++k) ASSERT_TRUE(step(body.state, body.physics, beside(all)).ok());
    // All samples touch the planes; the ball is far away in the refused step, and near again in the next.
    std::vector<Obstacle> many = all;
    many[0].point = {150, 0, 0};
    for (int k = 0; k < 5; ++k) many.push_back({.kind = ObstacleKind::Plane, .point = {0, 0, 500}});
    EXPECT_EQ(step(body.state, body.physics, beside(many)).error().code, ErrorCode::LimitExceeded);
    for (const float x : {112.0f, 112.0f, 150.0f, 105.0f}) {
        SCOPED_TRACE(x);
        all[0].point.x = x;
        const std::vector<double> gaps = gaps_to(body, all[0]);
        ASSERT_TRUE(step(body.state, body.physics, beside(all)).ok());
        EXPECT_EQ(expect_all_seen(body, gaps, 0) > 0, x != 150.0f);
    }
}

/// A few surfaces that come and go, turn, jump, bend and grow, and their reaches, as chance has it.
class AnySurfaces {
 public:
    explicit AnySurfaces(std::uint64_t seed) : dice_(seed) {
        states_.push_back(make_state(ball_chart(17, 30)));
        states_.push_back(make_state(wavy_chart(17, 150)));
        const std::uint32_t count = dice_.between(1, 5);
        for (std::uint32_t k = 0; k < count; ++k) add(k);
    }
    [[nodiscard]] std::span<const Obstacle> things() const { return things_; }
    [[nodiscard]] bool one_in(std::uint32_t n) { return dice_.one_in(n); }
    void go_on() {
        for (Obstacle& o : things_)
            if (!one_in(3)) move(o);
        if (one_in(15) && things_.size() < 7) add(dice_.below(size() + 1));
        if (one_in(15) && things_.size() > 1) things_.erase(things_.begin() + dice_.below(size()));
        if (one_in(20)) bend(states_[dice_.below(2)]);
    }

 private:
    [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(things_.size()); }
    [[nodiscard]] Vec3 around() {
        const double angle = double{dice_.real(0, 6.3f)}, far = double{dice_.real(90, 160)};
        return {float(far * std::cos(angle)), float(far * std::sin(angle)), dice_.real(-60, 60)};
    }
    void add(std::size_t at) {
        Obstacle o{.kind = one_in(5) ? ObstacleKind::Sphere : ObstacleKind::Surface, .point = around(), .radius = 20};
        if (o.kind == ObstacleKind::Surface) o.surface = &states_[dice_.below(2)];
        things_.insert(things_.begin() + std::ptrdiff_t(at), o);
    }
    void move(Obstacle& o) {
        // It comes, so that what was clear of it is met, then begins elsewhere.
        const float by = 1 - dice_.real(0, one_in(4) ? 0.08f : 0.02f);
        o.point = {by * o.point.x, by * o.point.y, by * o.point.z};
        if (one_in(25)) o.point = around();
        if (o.kind == ObstacleKind::Sphere) o.radius = dice_.real(10, 30);
        if (one_in(3)) turn(o, double{dice_.real(-0.3f, 0.3f)});
        if (one_in(10)) o.reach = one_in(2) ? 0 : dice_.real(5, 150);
    }
    void bend(State& state) {
        StateImpl& s = *state.impl();
        const float by = dice_.real(0.97f, 1.03f);
        for (std::uint32_t n = 0; n < s.total(); ++n) s.now.y[n] *= by;
        s.touch_all();
    }

    Dice dice_;
    std::vector<State> states_;
    std::vector<Obstacle> things_;
};

TEST(PhysicsSurfaces, AreSeenInAnyScene) {
    const auto seeds = static_cast<std::uint32_t>(asked("DGM_TEST_SEEDS", 12));
    std::size_t seen = 0;
    for (std::uint32_t seed = 0; seed < seeds && !HasFailure(); ++seed) {
        AnySurfaces scene(seed);
        Body body(organ_chart(17));
        for (int k = 0; k < 60 && !HasFailure(); ++k) {
            SCOPED_TRACE(testing::Message() << "seed " << seed << ", step " << k);
            scene.go_on();
            if (scene.one_in(25)) body.physics.reset();
            std::vector<std::vector<double>> gaps;
            for (const Obstacle& o : scene.things()) gaps.push_back(gaps_to(body, o));
            const auto done = step(body.state, body.physics, beside(scene.things(), 1, 0.3f));
            if (!done.ok()) {
                ASSERT_EQ(done.error().code, ErrorCode::LimitExceeded);
                continue;
            }
            for (std::uint32_t o = 0; o < scene.things().size(); ++o) seen += expect_all_seen(body, gaps[o], o);
        }
    }
    EXPECT_GT(seen, 1000 * seeds);
}

}  // namespace
}  // namespace dgm::test
