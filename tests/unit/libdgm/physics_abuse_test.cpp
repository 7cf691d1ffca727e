// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/physics_abuse_test.cpp
// What no body meets in life: steps either refuse, or leave every number finite and bounded.
#include <gtest/gtest.h>

#include <random>

#include "physics/physics_impl.h"
#include "physics_shapes.h"

namespace dgm::test {
namespace {

double farthest(const State& state) {
    const PointView now = state.positions(), rest = state.rest_positions();
    double far = 0;
    for (std::uint32_t k = 0; k < now.count; ++k) {
        const Vec3 d = now[k] - rest[k];
        const double length = std::sqrt(double{dot(d, d)});
        if (!std::isfinite(length)) return std::numeric_limits<double>::infinity();
        far = std::max(far, length);
    }
    return far;
}
bool is_finite(const StepReport& r) {
    return std::isfinite(r.kinetic) && std::isfinite(r.elastic) && std::isfinite(r.residual) &&
           std::isfinite(r.volume_error) && std::isfinite(r.pressure);
}

struct Shape {
    const char* name;
    ChartSpec chart;
};

/// The same surface with its inside out: the volume is below 0.
ChartSpec inverted_organ_chart(std::uint32_t side) {
    return closed_chart(side, [](std::array<double, 3> n) {
        return std::array<double, 3>{-75 * n[0], 60 * n[1], 50 * n[2]};
    });
}
/// Every third row of the grid is one point, and the last two rows are the same.
ChartSpec collapsed_sheet_chart() {
    return grid_chart(19, 17, [](double i, double j) {
        const double row = std::min(i, 17.0);
        return Point{float(5 * row), float(std::fmod(row, 3) == 0 ? 0 : 4 * j), 0};
    });
}
/// Quads that fold over each other.
ChartSpec crumpled_sheet_chart() {
    std::mt19937 random(3);
    return grid_chart(17, 17, [&random](double i, double j) {
        const auto shake = [&random] { return double(random() % 1000) / 50 - 10; };
        return Point{float(4 * i + shake()), float(4 * j + shake()), float(shake())};
    });
}

TEST(PhysicsAbuse, TenThousandTouchesByChance) {
    const Shape shapes[] = {{"organ", organ_chart(17)},
                            {"inside out", inverted_organ_chart(17)},
                            {"3 x 3", grid_chart(3, 3, [](double i, double j) {
                                 return Point{float(40 * i), float(40 * j), float(i * j)};
                             })}};
    for (const Shape& shape : shapes) {
        SCOPED_TRACE(shape.name);
        PhysicsOptions options{.material = Material{}};
        options.material->viscosity = 5e-3f;
        Body body(shape.chart, options);
        std::mt19937 random(17);
        const auto chance = [&random](double low, double high) {
            return float(low + (high - low) * double(random() % 65536) / 65536);
        };
        double worst = 0;
        int refused = 0;
        StepTool felt[3];
        ToolInput tools[3];
        for (int tick = 0; tick < 10'000; ++tick) {
            if (tick % 500 == 0) {
                ASSERT_TRUE(body.physics.set_dt(tick % 1000 == 0 ? 1e-3f : chance(1e-4, 0.05)).ok());
            }
            StepOptions how;
            how.cycles = 1 + random() % 3;
            how.tool_radius = chance(1, 40);
            how.friction = float(tick / 50 % 3);
            how.gravity = {chance(-20, 20), 0, chance(-20, 20)};
            const std::size_t count = random() % 4;
            for (std::uint32_t t = 0; t < count; ++t)
                tools[t] = {t,
                            static_cast<ToolKind>(random() % 3),
                            {chance(-90, 90), chance(-90, 90), chance(-90, 90)},
                            random() % 5 != 0};
            const auto done = step(body.state, body.physics, how, {tools, count}, felt);
            if (!done.ok()) {  // a body so fast that it may meet everything in this step
                ASSERT_EQ(done.error().code, ErrorCode::LimitExceeded) << tick << ": " << done.error().message;
                ++refused;
                continue;
            }
            ASSERT_TRUE(is_finite(done.value())) << tick;
            for (std::size_t t = 0; t < count; ++t)
                ASSERT_TRUE(std::isfinite(felt[t].force.x + felt[t].force.y + felt[t].force.z)) << tick;
            worst = std::max(worst, farthest(body.state));
        }
        EXPECT_LT(refused, 200);
        EXPECT_LT(worst, 2000) << "mm; the body measures 220 and tools are where it is";
        ASSERT_TRUE(body.physics.set_dt(0.1f).ok());
        StepOptions calm;
        calm.cycles = 20;
        for (int k = 0; k < 100; ++k) ASSERT_TRUE(step(body.state, body.physics, calm).ok());
        EXPECT_LT(farthest(body.state), 2.2) << "1 % of the diagonal";
    }
}

TEST(PhysicsAbuse, DegenerateGridsMoveOrAreRefused) {
    const Shape shapes[] = {{"collapsed rows", collapsed_sheet_chart()},
                            {"crumpled", crumpled_sheet_chart()},
                            {"a line", grid_chart(9, 9,
                                                  [](double i, double j) {
                                                      return Point{float(i + 3 * j), 0, 0};
                                                  })},
                            {"a needle", grid_chart(9, 9,
                                                    [](double i, double j) {
                                                        return Point{float(30 * i), float(1e-6 * j), 0};
                                                    })},
                            {"a point", grid_chart(9, 9, [](double, double) {
                                 return Point{1, 2, 3};
                             })}};
    for (const Shape& shape : shapes) {
        SCOPED_TRACE(shape.name);
        State state = make_state(shape.chart);
        PhysicsOptions options{.material = Material{}};
        options.metres_per_unit = 1e-3;
        auto made = Physics::create(state, options);
        if (!made.ok()) {
            EXPECT_STRNE(made.error().message, "");
            EXPECT_NE(made.error().code, ErrorCode::Ok);
            continue;
        }
        for (int k = 0; k < 60; ++k) {
            ToolInput ball;
            ball.position = {20, 20, float(12 - 0.2 * k)};
            StepOptions how;
            how.tool_radius = 10;
            how.gravity = {0, 0, -9.81f};
            const auto done = step(state, made.value(), how, {&ball, 1});
            ASSERT_TRUE(done.ok()) << done.error().message;
            ASSERT_TRUE(is_finite(done.value())) << k;
            ASSERT_LT(farthest(state), 200) << k;
        }
    }
    const State point = make_state(shapes[4].chart);
    PhysicsOptions options;
    options.metres_per_unit = 1e-3;
    EXPECT_EQ(Physics::create(point, options).error().code, ErrorCode::Unsupported);
}

TEST(PhysicsAbuse, ExtremesOfEveryNumber) {
    struct Extreme {
        Material material;
        float dt, gravity;
    };
    const Extreme extremes[] = {{{1e12f, 0.49f, 0, 1e12f, 1e-6f, 0}, 10, 1e6f},
                                {{1e12f, 0, 1e9f, 0, 1e-6f, 1e6f}, 1e-5f, 1e6f},
                                {{1e-6f, 0, 0, 0, 1e12f, 0}, 10, 1e6f},
                                {{1e-6f, 0.49f, 1e-9f, 1e12f, 1e12f, 1e6f}, 1e-5f, 1e6f},
                                {{200, 0.3f, 1e-3f, 0, 1e-6f, 0}, 10, 1e6f}};
    for (const Extreme& e : extremes) {
        SCOPED_TRACE(&e - extremes);
        PhysicsOptions options{.material = e.material};
        options.metres_per_unit = 1e-3;
        options.dt = e.dt;
        State state = make_state(organ_chart(17));
        auto made = Physics::create(state, options);
        if (!made.ok()) {
            EXPECT_STRNE(made.error().message, "");
            continue;
        }
        StepOptions how;
        how.tool_radius = 1e18f;
        how.gravity = {0, 0, -e.gravity};
        ToolInput tool;
        tool.position = {1e18f, -1e18f, 1e18f};
        for (int k = 0; k < 20; ++k) {
            const auto done = step(state, made.value(), how, {&tool, k % 2 == 0 ? 1u : 0u});
            EXPECT_TRUE(!done.ok() || is_finite(done.value())) << k;
            ASSERT_TRUE(std::isfinite(farthest(state))) << k;
            how.tool_radius = k < 10 ? 1e18f : 10;
        }
        // It is as good as new when it is reset.
        state.reset();
        made.value().reset();
        EXPECT_EQ(farthest(state), 0);
        ASSERT_TRUE(made.value().set_dt(1e-3f).ok());
        const auto calm = step(state, made.value());
        ASSERT_TRUE(calm.ok());
        EXPECT_FALSE(calm.value().clamped);
        EXPECT_LT(farthest(state), 1);
    }
    for (float Material::*field : {&Material::membrane, &Material::density}) {
        const State state = make_state(organ_chart(17));
        PhysicsOptions none{.material = Material{}};
        none.metres_per_unit = 1e-3;
        (*none.material).*field = 0;
        EXPECT_EQ(Physics::create(state, none).error().code, ErrorCode::BadArgument);
    }
}

TEST(PhysicsAbuse, ANumberThatIsNoneStopsOneStep) {
    // From within, since nothing that a caller gives can do it: the step is thrown away, and the next one is sound.
    for (const float viscosity : {0.0f, 2e-3f}) {
        PhysicsOptions options{.material = Material{}};
        options.material->viscosity = viscosity;
        Body body(organ_chart(33), options);
        StepOptions how;
        how.tool_radius = 10;
        ToolInput ball;
        ball.position = {0, 0, 55};
        for (int k = 0; k < 5; ++k) ASSERT_TRUE(step(body.state, body.physics, how, {&ball, 1}).ok());
        const double before = farthest(body.state);
        body.physics.impl()->velocity.p[0][77] = std::numeric_limits<float>::quiet_NaN();
        EXPECT_TRUE(step(body.state, body.physics, how, {&ball, 1}).value().clamped);
        EXPECT_EQ(farthest(body.state), before);
        for (int k = 0; k < 20; ++k) {
            const StepReport r = step(body.state, body.physics, how, {&ball, 1}).value();
            EXPECT_FALSE(r.clamped) << k;
            EXPECT_GT(r.cycles, 0u) << k;
            EXPECT_TRUE(is_finite(r));
        }
        EXPECT_NE(farthest(body.state), before);
    }
}

}  // namespace
}  // namespace dgm::test
