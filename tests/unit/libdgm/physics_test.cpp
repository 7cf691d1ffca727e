// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/physics_test.cpp
// Steps of a body: laws that hold for every step, closed forms, abuse, and arguments that are refused.
#include <dgm/dgm_physics.h>
#include <gtest/gtest.h>

#include <limits>
#include <new>

#include "physics_shapes.h"

namespace dgm::test {
namespace {

double length(Vec3 v) {
    return std::sqrt(double(v.x) * v.x + double(v.y) * v.y + double(v.z) * v.z);
}
double farthest_from_rest(const State& state) {
    const PointView now = state.positions(), rest = state.rest_positions();
    double far = 0;
    for (std::uint32_t k = 0; k < now.count; ++k) far = std::max(far, length(now[k] - rest[k]));
    return far;
}
bool is_finite_shape(const State& state) {
    const PointView now = state.positions();
    for (std::uint32_t k = 0; k < now.count; ++k)
        if (!std::isfinite(now[k].x) || !std::isfinite(now[k].y) || !std::isfinite(now[k].z)) return false;
    return true;
}
/// A ball of 10 mm above the middle of organ_chart(), its lowest point `depth` mm below the top.
ToolInput ball(double depth) {
    ToolInput in;
    in.position = {0, 0, float(60 - depth)};
    return in;
}
StepOptions ball_options(std::uint32_t cycles = 3) {
    StepOptions o;
    o.cycles = cycles;
    o.tool_radius = 10;
    return o;
}
std::vector<float> bits_of(const State& state) {
    std::vector<float> all;
    const PointView now = state.positions();
    for (std::uint32_t k = 0; k < now.count; ++k) all.insert(all.end(), {now[k].x, now[k].y, now[k].z});
    return all;
}

TEST(Physics, PokedBodyKeepsVolumeAndSeamsAndComesBack) {
    PhysicsOptions options{.material = Material{}};
    options.material->viscosity = 2e-3f;
    Body body(organ_chart(33), options);
    const Triangles triangles(body.state);
    const double before = triangles.volume(body.state);
    StepTool answer;
    double force = 0;
    for (int k = 0; k < 60; ++k) {
        const ToolInput in = ball(std::min(0.2 * k, 8.0));
        const auto done = step(body.state, body.physics, ball_options(), {&in, 1}, {&answer, 1});
        ASSERT_TRUE(done.ok()) << done.error().message;
        const StepReport& r = done.value();
        ASSERT_FALSE(r.clamped) << k;
        EXPECT_LE(std::fabs(r.volume_error), 1e-8) << k;
        EXPECT_NEAR(triangles.volume(body.state), before, 3e-8 * before) << "as floats, step " << k;
        expect_closed_seams(body.state);
        force = answer.force.z;
    }
    EXPECT_GT(answer.contacts, 0u);
    EXPECT_GT(force, 0.05);
    EXPECT_NEAR(body.state.positions()[16 * 33 + 16].z, 42, 0.3) << "the top lies on the ball";
    EXPECT_GT(farthest_from_rest(body.state), 7);
    for (int k = 0; k < 1500; ++k) ASSERT_TRUE(step(body.state, body.physics).ok());
    EXPECT_LT(farthest_from_rest(body.state), 0.1);
}

TEST(Physics, SameBitsForAnyLoopsAndAgain) {
    const auto run = [](bool plain) {
        Body body(organ_chart(33), {}, plain);
        for (int k = 0; k < 30; ++k) {
            const ToolInput in = ball(0.3 * k);
            EXPECT_TRUE(step(body.state, body.physics, ball_options(), {&in, 1}).ok());
        }
        return bits_of(body.state);
    };
    const std::vector<float> first = run(false), again = run(false), plain = run(true);
    EXPECT_EQ(std::memcmp(first.data(), again.data(), first.size() * sizeof(float)), 0);
    EXPECT_EQ(std::memcmp(first.data(), plain.data(), first.size() * sizeof(float)), 0);
}

TEST(Physics, EnergyNeverRisesWithoutWork) {
    for (const float dt : {1e-3f, 1e-2f}) {
        PhysicsOptions options{.material = Material{}};
        options.dt = dt;
        Body body(organ_chart(33), options);
        for (int k = 0; k < 40; ++k) {
            const ToolInput in = ball(0.3 * k);
            ASSERT_TRUE(step(body.state, body.physics, ball_options(), {&in, 1}).ok());
        }
        double last = std::numeric_limits<double>::infinity(), first = 0;
        for (int k = 0; k < 400; ++k) {
            const StepReport r = step(body.state, body.physics, ball_options()).value();
            const double now = r.kinetic + r.elastic;
            if (k == 0) first = now;
            EXPECT_LE(now, last + 1e-6 * first) << "step " << k << ", dt " << dt;
            last = now;
        }
        EXPECT_LT(last, 0.6 * first);
    }
}

TEST(Physics, ForceOnTheToolIsTheSlopeOfTheEnergy) {
    // At rest in contact the work of moving the ball goes into the body: F = dE/dz.
    PhysicsOptions options{.material = Material{}};
    options.dt = 0.1f;
    Body body(organ_chart(33), options);
    const auto settle = [&](double depth, double& energy) {
        StepTool answer;
        StepReport r;
        for (int k = 0; k < 60; ++k) {
            const ToolInput in = ball(depth);
            r = step(body.state, body.physics, ball_options(10), {&in, 1}, {&answer, 1}).value();
        }
        energy = r.elastic;
        return double(answer.force.z);
    };
    double low = 0, middle = 0, high = 0;
    settle(5.8, low);
    const double force = settle(6, middle);
    settle(6.2, high);
    EXPECT_GT(force, 0.05);
    EXPECT_NEAR((high - low) / 0.4e-3, force, 0.03 * force);
}

TEST(Physics, FreeFallIsExact) {
    PhysicsOptions options{.material = Material{}};
    options.material->foundation = 0;
    Body body(organ_chart(25), options);
    StepOptions o;
    o.gravity = {0, 0, -9.81f};
    for (int k = 0; k < 50; ++k) ASSERT_TRUE(step(body.state, body.physics, o).ok());
    // Implicit Euler: g dt^2 (1 + 2 + ... + n), in mm.
    const double fallen = 9.81e-6 * 50 * 51 / 2 * 1e3;
    const PointView now = body.state.positions(), rest = body.state.rest_positions();
    for (std::uint32_t k = 0; k < now.count; ++k)
        ASSERT_LT(length(now[k] - rest[k] + Vec3{0, 0, float(fallen)}), 2e-3 * fallen) << k;
}

TEST(Physics, LiesOnATableWithItsWeight) {
    PhysicsOptions options{.material = Material{}};
    options.material->foundation = 0;
    options.material->viscosity = 0.01f;
    options.dt = 5e-3f;
    Body body(organ_chart(25), options);
    double weight = 0;
    {
        const Triangles t(body.state);
        const PointView p = body.state.positions();
        for (std::size_t k = 0; k < t.indices.size(); k += 3) {
            const Vec3 a = p[t.indices[k + 1]] - p[t.indices[k]], b = p[t.indices[k + 2]] - p[t.indices[k]];
            weight += 0.5e-6 * length({a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x});
        }
        weight *= 5 * 9.81;
    }
    ToolInput table;  // nearly flat, and it says what rests on it
    table.position = {0, 0, -52 - 5000};
    StepOptions o;
    o.gravity = {0, 0, -9.81f};
    o.tool_radius = 5000;
    o.cycles = 10;
    StepTool answer;
    for (int k = 0; k < 800; ++k) {
        const auto r = step(body.state, body.physics, o, {&table, 1}, {&answer, 1});
        ASSERT_TRUE(r.ok());
        ASSERT_FALSE(r.value().clamped);
    }
    const PointView now = body.state.positions();
    double lowest = 0;
    for (std::uint32_t k = 0; k < now.count; ++k) lowest = std::min(lowest, double(now[k].z));
    EXPECT_NEAR(lowest, -52, 0.5);
    EXPECT_NEAR(-double(answer.force.z), weight, 0.02 * weight);
}

TEST(Physics, BlownUpSphereHoldsTheEnergyOfItsTension) {
    // Tension T = E t / (1 - nu) e of a sphere stretched by e, as against the pressure 2 T / R: energy T e times area.
    PhysicsOptions options{.material = Material{}};
    options.metres_per_unit = 0.1;
    options.material->foundation = 0;
    options.material->bending = 0;
    Body body(sphere_chart(65), options);
    std::vector<Pin> pins;
    const PointView rest = body.state.rest_positions();
    for (std::uint32_t k = 0; k < rest.count; ++k) {
        const std::uint32_t id = body.state.class_of(k);
        if (id == kNone || body.state.class_members(id)[0] == k) pins.push_back({k, 1.02f * rest[k]});
    }
    StepOptions o;
    o.pins = pins;
    const StepReport r = step(body.state, body.physics, o).value();
    const double e = 0.02, nu = 0.3, area = 4 * 3.14159265 * 0.01;
    EXPECT_NEAR(r.elastic, 200 / (1 - nu) * e * e * area, 0.01 * 200 / (1 - nu) * e * e * area);
}

TEST(Physics, HangingSheetStretchesAsItsWeightSays) {
    // Top row pinned: length rho g L^2 / (2 E t) more. Narrow, so that the pinned row's lateral hold matters little.
    const double side = 1, modulus = 100, density = 0.2, g = 9.81;
    PhysicsOptions options{.material = Material{}};
    options.metres_per_unit = 1;
    options.material = {float(modulus), 0, 0, 0, float(density), 0};
    options.dt = 10;
    Body body(grid_chart(65, 17, [&](double i, double j) { return Point{float(j / 64), float(-i / 64), 0}; }), options);
    std::vector<Pin> pins;
    const PointView rest = body.state.rest_positions();
    for (std::uint32_t j = 0; j < 17; ++j) pins.push_back({j, rest[j]});
    StepOptions o;
    o.pins = pins;
    o.gravity = {0, float(-g), 0};
    o.cycles = 30;
    for (int k = 0; k < 40; ++k) ASSERT_TRUE(step(body.state, body.physics, o).ok());
    const double exact = density * g * side * side / (2 * modulus);
    const double stretch = -1 - double(body.state.positions()[64 * 17 + 8].y);
    EXPECT_NEAR(stretch, exact, 0.01 * exact);
}

TEST(Physics, FlatPunchOnAFoundation) {
    // A plane pressed onto a plane sheet that only the foundation holds: F = kappa A d.
    PhysicsOptions options{.material = Material{}};
    options.metres_per_unit = 1e-3;
    options.dt = 1;
    Body body(grid_chart(33, 33, [](double i, double j) { return Point{float(3 * i), float(3 * j), 0}; }), options);
    Obstacle punch;
    punch.point = {0, 0, -2};
    punch.normal = {0, 0, -1};
    StepOptions o;
    o.obstacles = {&punch, 1};
    o.cycles = 10;
    StepReport r;
    for (int k = 0; k < 20; ++k) r = step(body.state, body.physics, o).value();
    const double area = 96e-3 * 96e-3, depth = 2e-3;
    EXPECT_NEAR(r.elastic, 0.5 * 2e4 * area * depth * depth, 1e-3 * 0.5 * 2e4 * area * depth * depth);
    EXPECT_EQ(r.contacts, 33u * 33u);
}

class Abuse : public testing::TestWithParam<float> {};
TEST_P(Abuse, EndsFiniteAndBackAtRest) {
    PhysicsOptions options{.material = Material{}};
    options.dt = GetParam();
    options.material->viscosity = 0.01f;
    Body body(organ_chart(33), options);
    const PointView rest = body.state.rest_positions();
    const auto calm = [&](const char* what) {
        for (int k = 0; k < 400; ++k) {
            ASSERT_TRUE(step(body.state, body.physics).ok());
            ASSERT_TRUE(is_finite_shape(body.state)) << what;
        }
        ASSERT_TRUE(body.physics.set_dt(0.1f).ok());
        StepOptions more;
        more.cycles = 20;
        for (int k = 0; k < 60; ++k) ASSERT_TRUE(step(body.state, body.physics, more).ok());
        EXPECT_LT(farthest_from_rest(body.state), 2) << what;  // 1 % of the diagonal
        ASSERT_TRUE(body.physics.set_dt(GetParam()).ok());
    };
    const ToolInput far = [] {
        ToolInput in;
        in.position = {1e6f, -1e6f, 1e6f};
        return in;
    }();
    ASSERT_TRUE(step(body.state, body.physics, ball_options(), {&far, 1}).ok());
    const ToolInput inside = ball(60);
    for (int k = 0; k < 5; ++k) ASSERT_TRUE(step(body.state, body.physics, ball_options(), {&inside, 1}).ok());
    calm("a tool in its middle");
    std::vector<Pin> pins;
    for (std::uint32_t k = 0; k < rest.count; ++k) {
        const std::uint32_t id = body.state.class_of(k);
        if (id == kNone || body.state.class_members(id)[0] == k) pins.push_back({k, {1, 2, 3}});
    }
    StepOptions o;
    o.pins = pins;
    ASSERT_TRUE(step(body.state, body.physics, o).ok());
    calm("all samples in one point");
    std::uint32_t random = 1;
    for (Pin& pin : pins) {
        const auto next = [&] { return float((random = random * 1664525 + 1013904223) >> 8) * 0x1p-24f; };
        pin.position = {200 * next() - 100, 200 * next() - 100, 200 * next() - 100};
    }
    ASSERT_TRUE(step(body.state, body.physics, o).ok());
    calm("samples thrown about");
}
INSTANTIATE_TEST_SUITE_P(Steps, Abuse, testing::Values(1e-3f, 1e-1f));

TEST(Physics, RefusesByNameAndChangesNothing) {
    Body body(organ_chart(25));
    const ToolInput in = ball(5);
    ASSERT_TRUE(step(body.state, body.physics, ball_options(), {&in, 1}).ok());
    const std::vector<float> before = bits_of(body.state);
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const auto refuses = [&](ErrorCode code, const StepOptions& o, std::span<const ToolInput> tools = {}) {
        const auto done = step(body.state, body.physics, o, tools);
        EXPECT_EQ(done.ok() ? ErrorCode::Ok : done.error().code, code) << done.error().message;
        EXPECT_EQ(std::memcmp(bits_of(body.state).data(), before.data(), before.size() * sizeof(float)), 0);
    };
    StepOptions o = ball_options();
    o.cycles = 0;
    refuses(ErrorCode::BadArgument, o);
    for (const float v : {nan, inf, 1e30f}) {
        o = ball_options();
        o.gravity = {0, v, 0};
        refuses(ErrorCode::BadArgument, o);
        o = ball_options();
        const Pin pin{0, {v, 0, 0}};
        o.pins = {&pin, 1};
        refuses(ErrorCode::BadArgument, o);
        o = ball_options();
        ToolInput bad = in;
        bad.position.y = v;
        refuses(ErrorCode::BadArgument, o, {&bad, 1});
        o.tool_radius = v;
        refuses(ErrorCode::BadArgument, o, {&in, 1});
        o = ball_options();
        Obstacle obstacle;
        obstacle.point.x = v;
        o.obstacles = {&obstacle, 1};
        refuses(ErrorCode::BadArgument, o);
    }
    o = ball_options();
    const Pin twice[2] = {{0, {}}, {24, {}}};  // corners of the map are one point
    o.pins = twice;
    refuses(ErrorCode::BadArgument, o);
    const Pin nowhere{25 * 25, {}};
    o.pins = {&nowhere, 1};
    refuses(ErrorCode::BadArgument, o);
    o = ball_options();
    const ToolInput same[2] = {in, in};
    refuses(ErrorCode::BadArgument, o, same);
    ToolInput strange = in;
    strange.kind = static_cast<ToolKind>(7);
    refuses(ErrorCode::Unsupported, o, {&strange, 1});
    Obstacle strange_obstacle;
    strange_obstacle.kind = static_cast<ObstacleKind>(9);
    o.obstacles = {&strange_obstacle, 1};
    refuses(ErrorCode::Unsupported, o);
    // Three planes that all samples are behind.
    Obstacle plane;
    plane.point = {0, 0, 500};
    plane.normal = {0, 0, 1};
    const Obstacle planes[3] = {plane, plane, plane};
    const Pin held{100, body.state.rest_positions()[100]};
    o = ball_options();
    o.pins = {&held, 1};
    o.obstacles = planes;
    refuses(ErrorCode::LimitExceeded, o, {&in, 1});
    Body other(organ_chart(33));
    EXPECT_EQ(step(other.state, body.physics).error().code, ErrorCode::BadArgument);
    // A step that was refused leaves nothing behind: the next one is that of a body which never met it.
    Body same_body(organ_chart(25));
    ASSERT_TRUE(step(same_body.state, same_body.physics, ball_options(), {&in, 1}).ok());
    for (Body* b : {&body, &same_body}) ASSERT_TRUE(step(b->state, b->physics, ball_options(), {&in, 1}).ok());
    EXPECT_EQ(bits_of(body.state), bits_of(same_body.state));
    for (const float dt : {0.0f, -1.0f, nan, inf, 11.0f})
        EXPECT_EQ(body.physics.set_dt(dt).error().code, ErrorCode::BadArgument);
}

TEST(Physics, CreateRefusesByName) {
    const State state = make_state(organ_chart(25));
    PhysicsOptions good{.material = Material{}};
    good.metres_per_unit = 1e-3;
    const auto code = [&](const PhysicsOptions& o) {
        const auto made = Physics::create(state, o);
        return made.ok() ? ErrorCode::Ok : made.error().code;
    };
    EXPECT_EQ(code(good), ErrorCode::Ok);
    PhysicsOptions o = good;
    o.metres_per_unit = 0;
    EXPECT_EQ(code(o), ErrorCode::Unsupported);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (float Material::*field : {&Material::membrane, &Material::poisson, &Material::bending, &Material::foundation,
                                   &Material::density, &Material::viscosity})
        for (const float v : {nan, -1.0f, 1e20f}) {
            o = good;
            (*o.material).*field = v;
            EXPECT_EQ(code(o), ErrorCode::BadArgument) << v;
        }
    o = good;
    o.material->bending = 1e3f;  // bends over 2 m, the body has 0.2 m
    EXPECT_EQ(code(o), ErrorCode::LimitExceeded);
    o = good;
    o.max_bytes = 1000;
    EXPECT_EQ(code(o), ErrorCode::LimitExceeded);
    o = good;
    o.dt = 0;
    EXPECT_EQ(code(o), ErrorCode::BadArgument);
    const State free = make_state(free_chart(17, 17, sheet));
    EXPECT_EQ(Physics::create(free, good).error().code, ErrorCode::Unsupported);
    const State tiny = make_state(grid_chart(2, 2, sheet));
    EXPECT_EQ(Physics::create(tiny, good).error().code, ErrorCode::Unsupported);
    const State three = make_state(grid_chart(3, 3, sheet));
    EXPECT_TRUE(Physics::create(three, good).ok());
}

ChartSpec with_material(ChartSpec chart, std::vector<float> values) {
    chart.add("material", ElementType::kF32, {values.size()}, values);
    return chart;
}

TEST(Physics, TakesUnitAndMaterialOfTheFile) {
    const Material soft{150, 0.25f, 5e-4f, 1e4f, 4, 1e-3f};
    const std::vector<float> stored{1e-2f, 150, 0.25f, 5e-4f, 1e4f, 4, 1e-3f};
    const State state = make_state(with_material(organ_chart(17), stored));
    EXPECT_EQ(stored_material(state).metres_per_unit, double{1e-2f});
    EXPECT_EQ(stored_material(state).material, soft);
    const auto pressed = [](const ChartSpec& chart, const PhysicsOptions& options) {
        State of = make_state(chart);
        auto physics = Physics::create(of, options);
        EXPECT_TRUE(physics.ok()) << physics.error().message;
        StepOptions o;
        o.gravity = {0, 0, -9};
        for (int k = 0; k < 5; ++k) EXPECT_TRUE(step(of, physics.value(), o).ok());
        return bits_of(of);
    };
    PhysicsOptions named{.material = soft};
    named.metres_per_unit = double{1e-2f};
    EXPECT_EQ(pressed(with_material(organ_chart(17), stored), {}), pressed(organ_chart(17), named));
    EXPECT_EQ(pressed(with_material(organ_chart(17), {1e-2f}), {.material = soft}), pressed(organ_chart(17), named));
    // What the options name goes before.
    const std::vector<float> other{5e-3f, 999, 0, 0, 0, 9, 0};
    EXPECT_EQ(pressed(with_material(organ_chart(17), other), named), pressed(organ_chart(17), named));
    const State unit_only = make_state(with_material(organ_chart(17), {1e-3f}));
    EXPECT_FALSE(stored_material(unit_only).material);
    EXPECT_TRUE(Physics::create(unit_only, {}).ok());
    const State silent = make_state(organ_chart(17));
    EXPECT_EQ(stored_material(silent).metres_per_unit, 0);
    EXPECT_EQ(Physics::create(silent, {}).error().code, ErrorCode::Unsupported);
    // Bends over 2.6 m; the body has 0.2 m in millimetres, 2 m in centimetres, 210 m in metres.
    for (const auto& [unit, code] : {std::pair{1e-3f, ErrorCode::LimitExceeded},
                                     std::pair{1e-2f, ErrorCode::LimitExceeded}, std::pair{1.0f, ErrorCode::Ok}}) {
        const State stiff = make_state(with_material(organ_chart(17), {unit, 150, 0, 1e3f, 0, 4, 0}));
        const auto made = Physics::create(stiff, {});
        EXPECT_EQ(made.ok() ? ErrorCode::Ok : made.error().code, code) << unit;
    }
}

TEST(Physics, TheLimitOfMemoryIsThatOfItsUse) {
    for (const ChartSpec& chart : {organ_chart(9), organ_chart(33), organ_chart(65), torus_chart(33), tree_chart(33),
                                   grid_chart(65, 17, sheet)}) {
        const State state = make_state(chart);
        CountedMemory use;
        PhysicsOptions o{.material = Material{}};
        o.metres_per_unit = 1e-3;
        o.material->viscosity = 1e-3f;
        o.allocator = use.allocator();
        ASSERT_TRUE(Physics::create(state, o).ok());
        EXPECT_EQ(use.now, 0u);
        std::uint64_t low = 0, high = std::uint64_t{1} << 40;  // the least limit that is enough
        while (high - low > 1000) {
            o.max_bytes = (low + high) / 2;
            (Physics::create(state, o).ok() ? high : low) = o.max_bytes;
        }
        EXPECT_LE(use.most, high);
        EXPECT_LE(double(high), 1.3 * double(use.most) + 65536);
    }
}

TEST(Physics, PinnedSamplesAndAllTheirCopiesStayWhereTheyAreAndComeFree) {
    Body body(organ_chart(25));
    const Vec3 corner = body.state.rest_positions()[0];  // four copies
    const Pin pin{24 * 25 + 24, corner + Vec3{0, 0, 3}};
    StepOptions o = ball_options();
    o.pins = {&pin, 1};
    for (int k = 0; k < 5; ++k) ASSERT_TRUE(step(body.state, body.physics, o).ok());
    for (const std::uint32_t s : {0u, 24u, 24u * 25u, 24u * 25u + 24u})
        EXPECT_LT(length(body.state.positions()[s] - pin.position), 1e-4) << s;
    ASSERT_TRUE(body.physics.set_dt(0.1f).ok());
    for (int k = 0; k < 60; ++k) ASSERT_TRUE(step(body.state, body.physics, ball_options(10)).ok());
    EXPECT_LT(farthest_from_rest(body.state), 0.05);
    expect_closed_seams(body.state);
}

TEST(Physics, GraspedSamplesFollowTheToolAndLetGo) {
    PhysicsOptions options{.material = Material{}};
    options.material->viscosity = 2e-3f;
    Body body(organ_chart(33), options);
    ToolInput in;
    in.kind = ToolKind::Grasp;
    StepTool answer;
    for (int k = 0; k < 100; ++k) {
        in.position = {0, 0, float(50 + 0.1 * std::min(k, 60))};
        ASSERT_TRUE(step(body.state, body.physics, ball_options(), {&in, 1}, {&answer, 1}).ok());
    }
    EXPECT_NEAR(body.state.positions()[16 * 33 + 16].z, 56, 0.2);
    EXPECT_LT(answer.force.z, -0.05) << "the body pulls the tool back";
    in.engaged = false;
    for (int k = 0; k < 1500; ++k) ASSERT_TRUE(step(body.state, body.physics, ball_options(), {&in, 1}).ok());
    EXPECT_LT(farthest_from_rest(body.state), 0.1);
}

TEST(Physics, TheCInterfaceGivesTheSameSteps) {
    Body body(organ_chart(25));
    const Image image = build({organ_chart(25)});
    dgm_asset* asset = nullptr;
    dgm_state* state = nullptr;
    dgm_physics* physics = nullptr;
    dgm_error error{};
    error.struct_size = sizeof error;
    ASSERT_EQ(dgm_asset_open_memory(image.bytes.data(), image.bytes.size(), nullptr, nullptr, &asset, &error), DGM_OK);
    dgm_state_options reach{};
    reach.struct_size = sizeof reach;
    reach.max_reach = 65;
    ASSERT_EQ(dgm_state_create(asset, 0, &reach, nullptr, &state, &error), DGM_OK) << error.message;
    EXPECT_EQ(dgm_physics_create(state, nullptr, nullptr, &physics, &error), DGM_UNSUPPORTED);
    EXPECT_EQ(physics, nullptr);
    EXPECT_EQ(dgm_physics_create(nullptr, nullptr, nullptr, &physics, &error), DGM_BAD_ARGUMENT);
    dgm_physics_options options{};
    options.struct_size = sizeof options;
    options.metres_per_unit = 1e-3;
    ASSERT_EQ(dgm_physics_create(state, &options, nullptr, &physics, &error), DGM_OK) << error.message;
    dgm_step_options o{};
    o.struct_size = sizeof o;
    o.tool_radius = 10;
    dgm_pin pin{};
    pin.struct_size = sizeof pin;
    pin.sample = 300;
    const Vec3 place = body.state.rest_positions()[300];
    pin.position[0] = place.x;
    pin.position[1] = place.y;
    pin.position[2] = place.z;
    o.pins = &pin;
    o.pin_count = 1;
    const Pin same{300, place};
    StepOptions cpp = ball_options();
    cpp.pins = {&same, 1};
    dgm_step_tool answer{};
    answer.struct_size = sizeof answer;
    dgm_step_report report{};
    report.struct_size = sizeof report;
    StepTool expected;
    StepReport told;
    for (int k = 0; k < 25; ++k) {
        const ToolInput in = ball(0.3 * k);
        dgm_tool_input tool{};
        tool.struct_size = sizeof tool;
        tool.position[2] = in.position.z;
        ASSERT_EQ(dgm_physics_step(state, physics, &o, &tool, 1, &answer, &report, &error), DGM_OK) << error.message;
        told = step(body.state, body.physics, cpp, {&in, 1}, {&expected, 1}).value();
    }
    const float* xyz[3];
    ASSERT_EQ(dgm_state_positions(state, xyz), body.state.sample_count());
    for (std::uint32_t k = 0; k < body.state.sample_count(); ++k)
        ASSERT_TRUE(same_bits(body.state.positions()[k], {xyz[0][k], xyz[1][k], xyz[2][k]})) << k;
    EXPECT_GT(answer.force[2], 0);
    EXPECT_EQ(answer.force[2], expected.force.z);
    EXPECT_EQ(answer.contacts, expected.contacts);
    EXPECT_EQ(report.elastic, told.elastic);
    EXPECT_EQ(report.pressure, told.pressure);
    EXPECT_EQ(report.layers, 0);
    o.tool_layer = cpp.tool_layer = 2e6f;
    const ToolInput in = ball(7.2);
    dgm_tool_input tool{};
    tool.struct_size = sizeof tool;
    tool.position[2] = in.position.z;
    ASSERT_EQ(dgm_physics_step(state, physics, &o, &tool, 1, &answer, &report, &error), DGM_OK) << error.message;
    told = step(body.state, body.physics, cpp, {&in, 1}, {&expected, 1}).value();
    EXPECT_EQ(answer.force[2], expected.force.z);
    EXPECT_GT(report.layers, 0);
    EXPECT_EQ(report.layers, told.layers);
    EXPECT_EQ(dgm_physics_set_dt(physics, -1, &error), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_physics_set_dt(physics, 0.01f, &error), DGM_OK);
    EXPECT_EQ(dgm_physics_step(state, nullptr, &o, nullptr, 0, nullptr, nullptr, &error), DGM_BAD_ARGUMENT);
    o.pin_count = 300;
    EXPECT_EQ(dgm_physics_step(state, physics, &o, nullptr, 0, nullptr, nullptr, &error), DGM_LIMIT_EXCEEDED);
    o.pin_count = 0;
    // A surface with its samples of the step before: all three arrays, or none.
    dgm_state* under = nullptr;
    ASSERT_EQ(dgm_state_create(asset, 0, &reach, nullptr, &under, &error), DGM_OK) << error.message;
    dgm_obstacle seat{};
    seat.struct_size = sizeof seat;
    seat.kind = DGM_OBSTACLE_KIND_SURFACE;
    seat.point[2] = -500;
    seat.surface = under;
    ASSERT_EQ(dgm_state_positions(under, seat.before), body.state.sample_count());
    o.obstacles = &seat;
    o.obstacle_count = 1;
    EXPECT_EQ(dgm_physics_step(state, physics, &o, nullptr, 0, nullptr, nullptr, &error), DGM_OK) << error.message;
    seat.before[1] = nullptr;
    EXPECT_EQ(dgm_physics_step(state, physics, &o, nullptr, 0, nullptr, nullptr, &error), DGM_BAD_ARGUMENT);
    dgm_state_destroy(under);
    dgm_physics_reset(physics);
    dgm_physics_destroy(physics);
    dgm_physics_destroy(nullptr);
    // Level of detail: the same as in C++.
    dgm_state* coarse = nullptr;
    dgm_detail* detail = nullptr;
    EXPECT_EQ(dgm_state_create_coarse(state, 0, nullptr, nullptr, &coarse, &error), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_state_create_coarse(nullptr, 2, nullptr, nullptr, &coarse, &error), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_state_create_coarse(state, 5, nullptr, nullptr, &coarse, &error), DGM_UNSUPPORTED);
    ASSERT_EQ(dgm_state_create_coarse(state, 2, nullptr, nullptr, &coarse, &error), DGM_OK) << error.message;
    EXPECT_EQ(dgm_detail_create(state, coarse, 4, nullptr, &detail, &error), DGM_BAD_ARGUMENT);
    EXPECT_EQ(dgm_detail_create(state, nullptr, 2, nullptr, &detail, &error), DGM_BAD_ARGUMENT);
    ASSERT_EQ(dgm_detail_create(state, coarse, 2, nullptr, &detail, &error), DGM_OK) << error.message;
    ASSERT_EQ(dgm_detail_show(detail, coarse, state, &error), DGM_OK) << error.message;
    for (std::uint32_t k = 0; k < body.state.sample_count(); ++k)
        ASSERT_TRUE(same_bits(body.state.rest_positions()[k], {xyz[0][k], xyz[1][k], xyz[2][k]})) << k;
    EXPECT_EQ(dgm_detail_show(detail, state, coarse, &error), DGM_BAD_ARGUMENT);
    dgm_detail_destroy(detail);
    dgm_detail_destroy(nullptr);
    dgm_state_destroy(coarse);
    dgm_state_destroy(state);
    dgm_asset_close(asset);
}

}  // namespace
}  // namespace dgm::test
