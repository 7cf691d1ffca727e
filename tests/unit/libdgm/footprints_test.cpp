// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/footprints_test.cpp
// Footprints by distance on the surface, against surfaces whose distances are known.
#include <gtest/gtest.h>

#include <dgm/deform.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "opened.h"

namespace dgm::test {
namespace {
constexpr double kPi = std::numbers::pi;

/// Presses at `sample` and compares every sample's weight with the kernel at distance(i, j) local units.
/// @return largest difference
double worst_weight(State& state, const DeformTable& table, Footprint footprint, std::uint32_t sample, float step,
                    double sigma, const std::function<double(int, int)>& distance) {
    state.reset();
    Touch touch;
    touch.sample = sample;
    touch.displacement = {0, 0, 1};
    touch.d_max = 1;
    touch.footprint = footprint;
    touch.step = step;
    const auto done = deform(state, table, touch);
    EXPECT_TRUE(done.ok()) << done.error().message;
    EXPECT_FALSE(done.ok() && done.value().truncated);
    const PointView p = state.positions(), rest = state.rest_positions();
    const int n = static_cast<int>(state.cols());
    double worst = 0;
    for (int i = 0; i < static_cast<int>(state.rows()); ++i)
        for (int j = 0; j < n; ++j) {
            const double d = distance(i, j) / double{step}, reach = table.reach();
            const double want = d < reach ? std::exp(-d * d / sigma) : 0;
            const std::size_t k = static_cast<std::size_t>(i * n + j);
            const double got = double{p.z[k]} - double{rest.z[k]};
            if (std::fabs(d - reach) > 0.05) worst = std::max(worst, std::fabs(got - want));
        }
    return worst;
}

DeformTable table_of(float sigma, std::uint32_t reach) {
    KernelOptions k;
    k.sigma = sigma;
    k.reach = reach;
    return DeformTable::create(k).value();
}

TEST(Footprints, SkewPlane) {
    // Parallelograms with sides 1 and 2 at an angle: straight lines are exact for both footprints.
    const auto skew = [](double i, double j) {
        return Point{static_cast<float>(i + 0.8 * j), static_cast<float>(1.6 * j), 0};
    };
    State state = make_state(grid_chart(61, 41, skew));
    const DeformTable table = table_of(20, 12);
    const std::uint32_t contact = 30 * 41 + 19;
    const auto straight = [](int i, int j) { return std::hypot(i - 30 + 0.8 * (j - 19), 1.6 * (j - 19)); };
    EXPECT_LT(worst_weight(state, table, Footprint::Surface, contact, 1.2f, 20, straight), 2e-5);
    EXPECT_LT(worst_weight(state, table, Footprint::Geodesic, contact, 1.2f, 20, straight), 2e-5);
}

TEST(Footprints, UnevenPlane) {
    // Rows grow apart by 4 % each.
    const auto x = [](double i) { return 25 * std::exp(0.04 * (i - 20)); };
    const auto uneven = [&](double i, double j) { return Point{static_cast<float>(x(i)), static_cast<float>(j), 0}; };
    State state = make_state(grid_chart(41, 41, uneven));
    const auto straight = [&](int i, int j) { return std::hypot(x(i) - 25, j - 20.0); };
    EXPECT_LT(worst_weight(state, table_of(20, 9), Footprint::Surface, 20 * 41 + 20, 1, 20, straight), 2e-5);
    EXPECT_LT(worst_weight(state, table_of(20, 9), Footprint::Geodesic, 20 * 41 + 20, 1, 20, straight), 2e-5);
}

TEST(Footprints, CylinderAcrossItsSeam) {
    const int around = 40;
    const double r = around / (2 * kPi);
    const auto tube = [&](double i, double j) {
        const double a = 2 * kPi * j / around;
        return Point{static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)), static_cast<float>(i)};
    };
    State state = make_state(grid_chart(41, 41, tube, tube_seams(41, 41)));
    for (const int jc : {0, 3, 38, 20}) {
        const auto rolled = [&](int i, int j) {
            double dj = std::fabs(j - jc);
            dj = std::min(dj, around - dj);
            return std::hypot(i - 20.0, dj);
        };
        // The polygon of 40 sides is 1 - (pi / 40)^2 / 6 of the circle.
        EXPECT_LT(worst_weight(state, table_of(16, 11), Footprint::Geodesic, 20 * 41 + static_cast<std::uint32_t>(jc),
                               1, 16, rolled),
                  2e-3)
            << jc;
        EXPECT_LT(worst_weight(state, table_of(16, 11), Footprint::Surface, 20 * 41 + static_cast<std::uint32_t>(jc), 1,
                               16, rolled),
                  2e-3)
            << jc;
        for (std::uint32_t i = 0; i < 41; ++i)
            ASSERT_TRUE(same_bits(state.positions()[i * 41], state.positions()[i * 41 + 40]));
    }
}

TEST(Footprints, SphereWithinTwoPerCentOfThePeak) {
    // A patch of a sphere on a very uneven grid; footprints from a third of the radius to as long as it.
    const double R = 20;
    const auto direction = [](double i, double j) {
        const double a = 0.02 * (i - 40) + 0.004 * (j - 40), b = 0.025 * (j - 40) * (1 + 0.006 * (i - 40));
        return std::array{std::sin(a), std::cos(a) * std::sin(b), std::cos(a) * std::cos(b)};
    };
    const auto sphere = [&](double i, double j) {
        const auto d = direction(i, j);
        return Point{static_cast<float>(R * d[0]), static_cast<float>(R * d[1]), static_cast<float>(R * d[2])};
    };
    ChartSpec chart = grid_chart(81, 81, sphere);
    std::vector<std::uint8_t> diagonals(80 * 80);
    std::mt19937 random(5);
    for (std::uint8_t& d : diagonals) d = random() & 1;
    chart.add("diagonals", ElementType::kU8, {80, 80}, diagonals);
    State state = make_state(chart);
    for (const auto& [reach, step] : {std::array{15.0, 0.45}, std::array{20.0, 0.6}, std::array{20.0, 1.0}}) {
        const std::uint32_t contact = 37 * 81 + 42;
        const auto c = direction(37, 42);
        const double sigma = reach * reach / 5;
        const auto great_circle = [&](int i, int j) {
            const auto d = direction(i, j);
            return R * std::acos(std::min(1.0, c[0] * d[0] + c[1] * d[1] + c[2] * d[2]));
        };
        EXPECT_LT(worst_weight(state, table_of(static_cast<float>(sigma), static_cast<std::uint32_t>(reach)),
                               Footprint::Geodesic, contact, static_cast<float>(step), sigma, great_circle),
                  0.01);
    }
}

TEST(Footprints, GeodesicDoesNotBleedToANearSheet) {
    // A sheet folded back over itself at distance 0.5: 20 rows out and 20 back.
    const auto hairpin = [](double i, double j) {
        const double bend = 0.25, out = 20;
        if (i <= out) return Point{static_cast<float>(i), static_cast<float>(j), 0};
        if (i <= out + 1) {
            const double a = kPi * (i - out);
            return Point{static_cast<float>(out + bend * std::sin(a)), static_cast<float>(j),
                         static_cast<float>(bend - bend * std::cos(a))};
        }
        return Point{static_cast<float>(2 * out + 1 - i), static_cast<float>(j), static_cast<float>(2 * bend)};
    };
    State state = make_state(grid_chart(42, 21, hairpin));
    Touch touch;
    touch.sample = 5 * 21 + 10;
    touch.displacement = {0, 0, 1};
    touch.d_max = 1;
    touch.footprint = Footprint::Geodesic;
    touch.step = 1;
    ASSERT_TRUE(deform(state, table_of(12, 9), touch).ok());
    for (std::uint32_t i = 20; i < 42; ++i)
        for (std::uint32_t j = 0; j < 21; ++j)
            ASSERT_EQ(state.positions().z[i * 21 + j], state.rest_positions().z[i * 21 + j]) << i << ' ' << j;
    EXPECT_NEAR(state.positions().z[8 * 21 + 14], std::exp(-25.0 / 12), 1e-5);
}

TEST(Footprints, EllipseInTheTangentPlane) {
    const auto turned = [](double i, double j) {  // grid steps of length 1 in a plane that leans
        return Point{static_cast<float>(0.6 * i), static_cast<float>(j), static_cast<float>(0.8 * i)};
    };
    State state = make_state(grid_chart(41, 41, turned));
    KernelOptions k;
    k.shape = KernelShape::Elliptic;
    k.radius_a = 6;
    k.radius_b = 2;
    k.angle = 0.5f;
    k.reach = 12;
    const DeformTable table = DeformTable::create(k).value();
    for (const Footprint footprint : {Footprint::Surface, Footprint::Geodesic}) {
        state.reset();
        Touch touch;
        touch.sample = 20 * 41 + 20;
        touch.displacement = {0, 1, 0};
        touch.d_max = 1;
        touch.footprint = footprint;
        touch.step = 1;
        ASSERT_TRUE(deform(state, table, touch).ok());
        for (int i = 0; i < 41; ++i)
            for (int j = 0; j < 41; ++j) {
                const double x = i - 20, y = j - 20, c = std::cos(0.5), s = std::sin(0.5);
                if (std::fabs(std::hypot(x, y) - 12) < 0.1) continue;
                const double p = (x * c + y * s) / 6, q = (y * c - x * s) / 2;
                const double want = std::hypot(x, y) < 12 ? std::exp(-p * p - q * q) : 0;
                ASSERT_NEAR(state.positions().y[i * 41 + j] - state.rest_positions().y[i * 41 + j], want, 1e-4)
                    << i << ' ' << j;
            }
    }
}

TEST(Footprints, SeamsStayClosedInEveryFootprint) {
    for (const Footprint footprint : {Footprint::Grid, Footprint::Surface, Footprint::Geodesic}) {
        const std::uint32_t side = 17;
        State state = make_state(grid_chart(side, side, sheet, octahedral_seams(side)));
        Touch touch;
        touch.displacement = {0.02f, -0.03f, 0.05f};
        touch.d_max = 1;
        touch.footprint = footprint;
        for (std::uint32_t s = 0; s < side * side; ++s) {
            touch.sample = s;
            touch.mode = s % 2 == 0 ? DeformMode::Elastic : DeformMode::Plastic;
            ASSERT_TRUE(deform(state, table_of(6, 5), touch).ok());
            if (s % 7 == 0) { ASSERT_TRUE(state.relax(0.01f, 30).ok()); }
            for (std::uint32_t id = 0; id < state.class_count(); ++id)
                for (const std::uint32_t copy : state.class_members(id))
                    ASSERT_TRUE(same_bits(state.positions()[copy], state.positions()[state.class_members(id)[0]]));
        }
    }
}

TEST(Footprints, FreeDomain) {
    const auto flat = [](double i, double j) { return Point{static_cast<float>(i), static_cast<float>(j), 0}; };
    for (const Footprint footprint : {Footprint::Surface, Footprint::Geodesic}) {
        State state = make_state(free_chart(16, 14, flat));
        Touch touch;
        touch.sample = 3 * 14 + 4;
        touch.displacement = {0, 0, 1};
        touch.d_max = 1;
        touch.footprint = footprint;
        touch.step = 1;
        ASSERT_TRUE(deform(state, table_of(6, 5), touch).ok());
        const PointView p = state.positions();
        for (std::uint32_t s = 0; s < state.sample_count(); ++s) {
            if (!state.on_surface(s)) continue;
            const double d = std::hypot(double{p.x[s]} - 3, double{p.y[s]} - 4);
            EXPECT_NEAR(p.z[s], d < 5 ? std::exp(-d * d / 6) : 0, 1e-4) << s;
        }
    }
}

TEST(Footprints, Refusals) {
    State state = make_state(grid_chart(9, 9, sheet));
    Touch touch;
    touch.sample = 40;
    touch.displacement = {0, 0, 1};
    touch.d_max = 1;
    touch.footprint = static_cast<Footprint>(4);
    EXPECT_EQ(deform(state, table_of(4, 3), touch).error().code, ErrorCode::Unsupported);
    touch.footprint = Footprint::Geodesic;
    touch.step = -1;
    EXPECT_EQ(deform(state, table_of(4, 3), touch).error().code, ErrorCode::BadArgument);
    touch.step = NAN;
    EXPECT_EQ(deform(state, table_of(4, 3), touch).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(state.positions().z[40], state.rest_positions().z[40]);
}

}  // namespace
}  // namespace dgm::test
