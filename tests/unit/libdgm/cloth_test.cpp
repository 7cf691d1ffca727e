// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/cloth_test.cpp
// Cloth as a whole: seams, same bits, energy, abuse, and what is refused.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "cloth_shapes.h"
#include "rows/rows.h"

#if DGM_HAS_AVX
namespace dgm::detail::cloth {
extern const Kernels kAvx2Kernels;
}
#endif

namespace dgm::test {
namespace {

std::vector<float> shape_of(const State& state) {
    std::vector<float> out;
    for (std::uint32_t k = 0; k < state.sample_count(); ++k)
        for (const float v : {state.positions()[k].x, state.positions()[k].y, state.positions()[k].z}) out.push_back(v);
    return out;
}
bool same(const std::vector<float>& a, const std::vector<float>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}
bool is_sound(const State& state) {
    const auto all = shape_of(state);
    return std::all_of(all.begin(), all.end(), [](float v) { return std::isfinite(v); });
}
Obstacle ball(Vec3 centre, float radius) {
    Obstacle o;
    o.kind = ObstacleKind::Sphere;
    o.point = centre;
    o.radius = radius;
    return o;
}

/// A skirt that hangs from its waist and meets a ball.
struct Skirt : Drape {
    Obstacle thing = ball({0.2f, 0.1f, -0.4f}, 0.15f);
    explicit Skirt(const ClothOptions& o = {}) : Drape(skirt_chart(33, 65, 0.15, 0.5, 0.8), o) {
        for (std::uint32_t k = 0; k + 1 < 65; ++k) pin(k);
        how.obstacles = {&thing, 1};
    }
};

TEST(Cloth, SeamsStaySewnToTheBit) {
    Skirt s;
    for (int k = 0; k < 40; ++k) {
        s.run(1);
        for (std::uint32_t i = 0; i < 33; ++i) {
            const Vec3 a = s.state.positions()[i * 65], b = s.state.positions()[i * 65 + 64];
            ASSERT_EQ(std::memcmp(&a, &b, sizeof a), 0);
        }
    }
}

TEST(Cloth, SeamBendsAsTheRestDoes) {
    // A tube that is pressed flat by nothing stays round, and one that is turned by half a turn is the same: where the
    // seam lies makes no difference.
    ClothOptions o;
    o.fabric = {.warp = 500, .weft = 500, .shear = 100, .bending = 1e-2f, .damping = 2};
    double sag[2];
    for (const int turned : {0, 1}) {
        SeamPairs seams;
        for (std::uint32_t i = 0; i < 17; ++i) seams.push_back({i * 33, i * 33 + 32});
        // A tube that lies: held along its lowest line, or by the seam opposite to it.
        Drape d(grid_chart(
                    17, 33,
                    [&](double i, double j) {
                        const double t = 2 * std::numbers::pi * (std::fmod(j, 32) / 32 + 0.5 * turned);
                        return Point{float(0.02 * i), float(0.1 * std::sin(t)), float(-0.1 * std::cos(t))};
                    },
                    seams),
                o);
        const std::uint32_t lowest = turned ? 16 : 0, top = turned ? 0 : 16;
        for (std::uint32_t i = 0; i < 17; ++i) d.pin(i * 33 + lowest);
        d.run(300);
        sag[turned] = 0.1 - d.at(8, top).z;
    }
    EXPECT_GT(sag[0], 1e-3);
    EXPECT_NEAR(sag[0], sag[1], 0.01 * sag[0]);
}

TEST(Cloth, SameBitsTwiceAndWithEveryLoop) {
    std::vector<float> first;
    for (int round = 0; round < 4; ++round) {
        ClothOptions o;
        o.self_contact = true;
        o.plain_loops = round == 1;
        Skirt s(o);
#if DGM_HAS_AVX
        if (round == 2 && __builtin_cpu_supports("avx2")) s.cloth.impl()->kernels = &detail::cloth::kAvx2Kernels;
#endif
        if (round == 1) { EXPECT_STREQ(s.cloth.impl()->kernels->name, "plain"); }
        s.run(30);
        if (round == 0) first = shape_of(s.state);
        EXPECT_TRUE(same(first, shape_of(s.state))) << round;
    }
}

TEST(Cloth, EnergyDoesNotRiseWithoutWork) {
    for (const std::uint32_t substeps : {1u, 2u, 4u}) {
        ClothOptions o;
        o.fabric.damping = 0;
        Drape d(sheet_chart(33, 33, 1, 1), o);
        d.pin(0);
        d.pin(32);
        d.how.substeps = substeps;
        ClothReport last = d.run(1);
        const double start = last.kinetic + last.elastic + last.potential;
        for (int k = 0; k < 400; ++k) {
            const ClothReport r = d.run(1);
            const double rise = (r.kinetic + r.elastic + r.potential) - (last.kinetic + last.elastic + last.potential);
            ASSERT_LT(rise, 1e-6) << substeps << ' ' << k;  // of about 1 J
            last = r;
        }
        EXPECT_LT(last.kinetic + last.elastic + last.potential, start - 0.3);
    }
}

TEST(Cloth, LyingClothComesToRest) {
    Drape d(grid_chart(33, 33, [](double i, double j) {
        return Point{float(i / 32 - 0.5), float(j / 32 - 0.5), 0.3f};
    }));
    const Obstacle thing = ball({0, 0, 0}, 0.25f);
    Obstacle floor;
    floor.point = {0, 0, -0.3f};
    const Obstacle all[] = {thing, floor};
    d.how.obstacles = all;
    d.run(500);
    // Here and there a sample still slips, so that single frames tell little.
    double kinetic = 0;
    for (int k = 0; k < 100; ++k) kinetic += 0.01 * d.run(1).kinetic;
    EXPECT_LT(kinetic, 1e-6);
}

TEST(Cloth, OddSizesWork) {
    for (const auto& [rows, cols] :
         {std::pair{3u, 3u}, {3u, 50u}, {50u, 3u}, {4u, 4u}, {31u, 47u}, {6u, 100u}, {64u, 64u}}) {
        Drape d(sheet_chart(rows, cols, 0.01 * rows, 0.01 * cols));
        d.pin_rows(0, 1);
        const ClothReport r = d.run(60);
        EXPECT_TRUE(is_sound(d.state)) << rows << ' ' << cols;
        EXPECT_LT(d.mean_of_row(rows - 1).z, -0.005) << rows << ' ' << cols;
        EXPECT_LT(r.elastic, 1);
    }
}

TEST(Cloth, AbuseLeavesNumbersFinite) {
    std::uint32_t seed = 1;
    const auto random = [&] {
        seed = seed * 1664525u + 1013904223u;
        return float(seed >> 8) / float(1 << 24);
    };
    for (int what = 0; what < 6; ++what) {
        ClothOptions o;
        o.self_contact = what == 5;
        Drape d(sheet_chart(33, 33, 1, 1), o);
        if (what < 2 || what == 5) {  // thrown about, or into one point
            detail::StateImpl& s = *d.state.impl();
            for (std::uint32_t k = 0; k < s.total(); ++k) {
                s.now.x[k] = what == 1 ? 0 : random();
                s.now.y[k] = what == 1 ? 0 : random();
                s.now.z[k] = what == 1 ? 0 : random();
            }
            ASSERT_TRUE(d.cloth.take_shape(d.state).ok());
        }
        d.pin_rows(0, 1);
        d.how.pins = d.pins;
        if (what == 2) d.how.dt = 100.0f / 60;
        if (what == 3) d.how.gravity = {0, 0, -1e5f};
        d.how.tool_radius = 0.1f;
        for (int k = 0; k < 60; ++k) {
            ToolInput tool{.kind = what == 4 ? ToolKind::Grasp : ToolKind::Touch, .position = {0.5f, 0.5f, 0.02f}};
            if (k % 20 > 10) tool.position = {what == 4 ? 1e6f : 0.5f, 0.5f, 1e6f};
            ASSERT_TRUE(step(d.state, d.cloth, d.how, {&tool, 1}).ok());
            ASSERT_TRUE(is_sound(d.state)) << what << ' ' << k;
        }
    }
}

TEST(Cloth, RandomStartComesBack) {
    // Samples thrown out of a flat sheet by up to a cell; it is let go without gravity.
    Drape d(sheet_chart(17, 17, 1, 1));
    detail::StateImpl& s = *d.state.impl();
    for (std::uint32_t k = 0; k < s.total(); ++k) s.now.z[k] = 0.03f * float(int(k * 2654435761u >> 28) - 8) / 8;
    ASSERT_TRUE(d.cloth.take_shape(d.state).ok());
    const double before = d.cloth.impl()->elastic;
    d.how.gravity = {};
    const ClothReport r = d.run(600);
    EXPECT_LT(r.elastic + r.kinetic, 1e-4 * before);
}

TEST(Cloth, MobilityZeroHolds) {
    ChartSpec chart = sheet_chart(9, 9, 1, 1);
    std::vector<float> contact;
    for (int k = 0; k < 81; ++k) contact.insert(contact.end(), {1, k < 9 ? 0.0f : 1.0f});
    chart.add("contact", layout::ElementType::kF32, {9, 9, 2}, contact);
    Drape d(chart);
    d.run(30);
    for (std::uint32_t k = 0; k < 9; ++k) EXPECT_EQ(d.state.positions()[k].z, 0);
    EXPECT_LT(d.at(8, 4).z, -0.1);
}

TEST(Cloth, RestsToTheBitWhereNothingActs) {
    Drape d(skirt_chart(17, 33, 0.2, 0.4, 0.5));
    d.how.gravity = {};
    const auto before = shape_of(d.state);
    d.run(3);
    const auto now = shape_of(d.state);
    for (std::size_t k = 0; k < now.size(); ++k) EXPECT_NEAR(now[k], before[k], 1e-6);
}

TEST(Cloth, TakesTheFabricOfTheFile) {
    ChartSpec chart = sheet_chart(9, 9, 100, 100);
    const std::vector<float> denim{1e-2f, 9000, 0.25f, 4e-5f, 7, 0.45f, 2e-3f};
    chart.add("material", ElementType::kF32, {denim.size()}, denim);
    const State state = make_state(chart);
    const std::optional<Fabric> found = stored_fabric(state);
    ASSERT_TRUE(found.has_value());
    EXPECT_FLOAT_EQ(found->warp, 9600);
    EXPECT_FLOAT_EQ(found->weft, 9600);
    EXPECT_FLOAT_EQ(found->cross, 2400);
    EXPECT_FLOAT_EQ(found->shear, 3600);
    EXPECT_EQ(found->bending, 4e-5f);
    EXPECT_EQ(found->density, 0.45f);
    EXPECT_EQ(found->damping, Fabric{}.damping);
    // It hangs as that fabric does: rho g L^2 / 2 over the membrane's modulus, since its sides are free.
    ClothOptions o;
    o.fabric = *found;
    o.thickness = 0;
    Drape d(sheet_chart(33, 9, 1, 0.1), o);
    d.how.gravity = {kG, 0, 0};
    d.pin_rows(0, 1);
    d.run(100);
    const double exact = 0.45 * double{kG} / (2 * 9000);
    EXPECT_NEAR(d.mean_of_row(32).x - 1, exact, 0.03 * exact);
    ChartSpec unit_only = sheet_chart(9, 9, 100, 100);
    unit_only.add("material", ElementType::kF32, {1}, std::vector<float>{1e-2f});
    EXPECT_FALSE(stored_fabric(make_state(unit_only)).has_value());
    EXPECT_FALSE(stored_fabric(make_state(sheet_chart(9, 9, 1, 1))).has_value());
    EXPECT_TRUE(Cloth::create(make_state(unit_only), {}).ok());
}

TEST(Cloth, BadOptionsAreRefusedByName) {
    const State state = make_state(sheet_chart(9, 9, 1, 1));
    const auto code = [&](auto change) {
        ClothOptions o;
        o.metres_per_unit = 1;
        change(o);
        auto r = Cloth::create(state, o);
        EXPECT_FALSE(r.ok());
        EXPECT_GT(std::strlen(r.error().message), 10u);
        return r.error().code;
    };
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const float v : {nan, inf, -1.0f}) {
        EXPECT_EQ(code([&](ClothOptions& o) { o.fabric.warp = v; }), ErrorCode::BadArgument);
        EXPECT_EQ(code([&](ClothOptions& o) { o.fabric.weft = v; }), ErrorCode::BadArgument);
        EXPECT_EQ(code([&](ClothOptions& o) { o.fabric.cross = v; }), ErrorCode::BadArgument);
        EXPECT_EQ(code([&](ClothOptions& o) { o.fabric.shear = v; }), ErrorCode::BadArgument);
        EXPECT_EQ(code([&](ClothOptions& o) { o.fabric.bending = v; }), ErrorCode::BadArgument);
        EXPECT_EQ(code([&](ClothOptions& o) { o.fabric.density = v; }), ErrorCode::BadArgument);
        EXPECT_EQ(code([&](ClothOptions& o) { o.fabric.damping = v; }), ErrorCode::BadArgument);
        EXPECT_EQ(code([&](ClothOptions& o) { o.thickness = v; }), ErrorCode::BadArgument);
        EXPECT_EQ(code([&](ClothOptions& o) { o.metres_per_unit = double{v}; }), ErrorCode::BadArgument);
    }
    EXPECT_EQ(code([](ClothOptions& o) { o.fabric.cross = 1950; }), ErrorCode::BadArgument);
    EXPECT_EQ(code([](ClothOptions& o) { o.metres_per_unit = 0; }), ErrorCode::Unsupported);
    EXPECT_EQ(code([](ClothOptions& o) { o.max_bytes = 1000; }), ErrorCode::LimitExceeded);
    EXPECT_EQ(code([](ClothOptions& o) { o.self_contact = true, o.thickness = 0; }), ErrorCode::BadArgument);
    EXPECT_EQ(code([](ClothOptions& o) { o.self_contact = true, o.thickness = 0.5f; }), ErrorCode::BadArgument);
    EXPECT_EQ(code([](ClothOptions& o) {
                  o.allocator.allocate = [](void*, std::size_t, std::size_t) -> void* { return nullptr; };
              }),
              ErrorCode::BadArgument);
}

TEST(Cloth, BadStepsAreRefusedAndChangeNothing) {
    Drape d(sheet_chart(9, 9, 1, 1)), other(sheet_chart(9, 11, 1, 1));
    d.run(5);
    const auto before = shape_of(d.state);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const auto code = [&](auto change) {
        ClothStep o;
        ToolInput tool{.position = {0, 0, 5}};
        o.tool_radius = 1;
        change(o, tool);
        auto r = step(d.state, d.cloth, o, {&tool, 1});
        EXPECT_FALSE(r.ok());
        EXPECT_TRUE(same(before, shape_of(d.state)));
        return r.error().code;
    };
    const Pin far[] = {{81, {}}}, twice[] = {{4, {}}, {4, {}}}, nowhere[] = {{3, {nan, 0, 0}}};
    Obstacle itself;
    itself.kind = ObstacleKind::Surface;
    itself.surface = &d.state;
    Obstacle none = ball({}, 0);
    std::vector<Obstacle> many(64, ball({0, 0, 9}, 1));
    const ErrorCode bad = ErrorCode::BadArgument;
    EXPECT_EQ(code([&](ClothStep& o, ToolInput&) { o.dt = 0; }), bad);
    EXPECT_EQ(code([&](ClothStep& o, ToolInput&) { o.dt = nan; }), bad);
    EXPECT_EQ(code([&](ClothStep& o, ToolInput&) { o.dt = 11; }), bad);
    EXPECT_EQ(code([&](ClothStep& o, ToolInput&) { o.substeps = 0; }), bad);
    EXPECT_EQ(code([&](ClothStep& o, ToolInput&) { o.cycles = 101; }), bad);
    EXPECT_EQ(code([&](ClothStep& o, ToolInput&) { o.friction = -1; }), bad);
    EXPECT_EQ(code([&](ClothStep& o, ToolInput&) { o.gravity.y = nan; }), bad);
    EXPECT_EQ(code([&](ClothStep& o, ToolInput&) { o.pins = far; }), bad);
    EXPECT_EQ(code([&](ClothStep& o, ToolInput&) { o.pins = twice; }), bad);
    EXPECT_EQ(code([&](ClothStep& o, ToolInput&) { o.pins = nowhere; }), bad);
    EXPECT_EQ(code([&](ClothStep& o, ToolInput&) { o.obstacles = {&itself, 1}; }), bad);
    EXPECT_EQ(code([&](ClothStep& o, ToolInput&) { o.obstacles = {&none, 1}; }), bad);
    EXPECT_EQ(code([&](ClothStep& o, ToolInput&) { o.obstacles = many; }), ErrorCode::LimitExceeded);
    EXPECT_EQ(code([&](ClothStep& o, ToolInput&) { o.tool_radius = 0; }), bad);
    EXPECT_EQ(code([&](ClothStep&, ToolInput& t) { t.position.z = nan; }), bad);
    EXPECT_EQ(code([&](ClothStep&, ToolInput& t) { t.tool = 64; }), bad);
    EXPECT_EQ(code([&](ClothStep&, ToolInput& t) { t.kind = ToolKind(7); }), ErrorCode::Unsupported);
    EXPECT_EQ(step(d.state, other.cloth).error().code, bad);
    EXPECT_EQ(other.cloth.take_shape(d.state).error().code, bad);
    // A pin that was refused is not held afterwards.
    d.run(10);
    EXPECT_LT(d.at(0, 4).z, -0.1);
}

}  // namespace

/// A curtain of 1 m; samples off the border are moved by chance, up to 0.7 steps, so that some quads are thin, twisted
/// or not convex, as on baked maps.
ChartSpec uneven_curtain(std::uint32_t side) {
    return grid_chart(side, side, [=](double i, double j) {
        const double n = side - 1;
        const bool inner = i > 0 && j > 0 && i < n && j < n;
        std::uint32_t r = static_cast<std::uint32_t>(i * side + j) * 2654435761u;
        r = (r ^ r >> 15) * 2246822519u;
        r ^= r >> 13;
        const double by = inner ? 1.4 / 255 : 0, a = by * ((r >> 8 & 255) - 127.5), b = by * ((r >> 16 & 255) - 127.5);
        return Point{float((j + a) / n), 0, float(-(i + b) / n)};
    });
}
TEST(Cloth, UnevenQuadsDoNotHoldItUp) {
    ClothOptions o;
    o.fabric = {.warp = 800, .weft = 800, .shear = 400, .bending = 1e-5f, .density = 0.25f, .damping = 1};
    Drape d(uneven_curtain(33), o);
    const auto& on = d.cloth.impl()->fine().on;
    float twist = 0;
    for (std::uint32_t k = 0; k < d.state.sample_count(); ++k)
        twist = std::max(twist, std::fabs(on.twist_u[d.cloth.impl()->spot_of(k)]));
    EXPECT_GT(twist, 20) << "else the test tests nothing";
    d.pin_rows(0, 1);
    d.how.cycles = 2;
    d.run(60);
    const double exact = 0.25 * double{kG} / (2 * 800);
    EXPECT_NEAR(-1 - d.mean_of_row(32).z, exact, 0.1 * exact);
}
}  // namespace dgm::test
