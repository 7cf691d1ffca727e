// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/kernels_test.cpp
// Elliptic and user kernels, the profile and its bound, painted stiffness and mobility.
#include <gtest/gtest.h>

#include <dgm/deform.h>

#include <cmath>
#include <limits>
#include <vector>

#include "opened.h"

namespace dgm::test {
namespace {

Point flat(double i, double j) {
    return {static_cast<float>(i), static_cast<float>(j), 0};
}

Touch lift(std::uint32_t sample) {
    Touch touch;
    touch.sample = sample;
    touch.displacement = {0, 0, 1};
    touch.d_max = 1;
    touch.footprint = Footprint::Grid;
    return touch;
}

KernelOptions ellipse(float a, float b, float angle, std::uint32_t reach, KernelEnd end = KernelEnd::Printed) {
    KernelOptions k;
    k.shape = KernelShape::Elliptic;
    k.radius_a = a;
    k.radius_b = b;
    k.angle = angle;
    k.reach = reach;
    k.end = end;
    return k;
}

double ellipse_at(double x, double y, double a, double b, double angle) {
    const double p = x * std::cos(angle) + y * std::sin(angle), q = y * std::cos(angle) - x * std::sin(angle);
    return std::exp(-(p / a) * (p / a) - (q / b) * (q / b));
}

TEST(Kernels, EllipseHasItsRadiiAndAngle) {
    // Axis a along +i: 1/e at 6 rows and at 2 columns.
    const DeformTable upright = DeformTable::create(ellipse(6, 2, 0, 10)).value();
    EXPECT_NEAR(upright.weight(6, 0), std::exp(-1), 1e-7);
    EXPECT_NEAR(upright.weight(0, 2), std::exp(-1), 1e-7);
    EXPECT_NEAR(upright.weight(0, 6), std::exp(-9), 1e-7);
    EXPECT_NEAR(upright.weight(3, -1), std::exp(-0.5), 1e-7);
    EXPECT_EQ(upright.weight(10, 0), 0.0f);
    // Turned towards +j: the long axis lies along (3, 4).
    const float angle = std::atan2(4.0f, 3.0f);
    const DeformTable turned = DeformTable::create(ellipse(5, 1, angle, 8)).value();
    EXPECT_NEAR(turned.weight(3, 4), std::exp(-1), 1e-6);
    EXPECT_NEAR(turned.weight(-3, -4), std::exp(-1), 1e-6);
    EXPECT_NEAR(turned.weight(4, -3), std::exp(-25), 1e-9);
    for (int i = -7; i < 8; ++i)
        for (int j = -7; j < 8; ++j) {
            EXPECT_NEAR(turned.weight(float(i), float(j)), ellipse_at(i, j, 5, 1, double{angle}), 1e-6);
            EXPECT_EQ(turned.weight(float(i), float(j)), turned.weight(float(-i), float(-j)));
        }
    // A circle is the ellipse of equal radii.
    KernelOptions circle;
    circle.sigma = 9;
    circle.reach = 7;
    const DeformTable round = DeformTable::create(circle).value();
    const DeformTable equal = DeformTable::create(ellipse(3, 3, 0.7f, 7)).value();
    for (int i = -6; i < 7; ++i)
        for (int j = -6; j < 7; ++j)
            EXPECT_NEAR(round.weight(float(i), float(j)), equal.weight(float(i), float(j)), 3e-7);
}

TEST(Kernels, CompactEllipseEndsOnTheEllipse) {
    const DeformTable t = DeformTable::create(ellipse(4, 2, 0, 12, KernelEnd::Compact)).value();
    EXPECT_EQ(t.weight(0, 0), 1.0f);
    EXPECT_GT(t.weight(11, 0), 0.0f);
    EXPECT_GT(t.weight(0, 5), 0.0f);
    EXPECT_EQ(t.weight(0, 6), 0.0f);
    EXPECT_EQ(t.weight(0, 7), 0.0f);
    EXPECT_EQ(t.weight(9, 5), 0.0f);
}

TEST(Kernels, EllipseOnTheGridAndAcrossQuarterTurns) {
    State state = make_state(grid_chart(31, 31, flat));
    const DeformTable t = DeformTable::create(ellipse(6, 2.5f, 0.4f, 11)).value();
    ASSERT_TRUE(deform(state, t, lift(15 * 31 + 14)).ok());
    for (int i = 0; i < 31; ++i)
        for (int j = 0; j < 31; ++j)
            ASSERT_NEAR(state.positions().z[i * 31 + j],
                        std::abs(i - 15) < 11 && std::abs(j - 14) < 11 ? ellipse_at(i - 15, j - 14, 6, 2.5, 0.4) : 0,
                        1e-6);
    // Around the corner the sides i = 0 and j = 0 meet: images are quarter turns of the plane.
    const std::uint32_t side = 25;
    State corner = make_state(grid_chart(side, side, flat, corner_seams(side)));
    for (const auto& [ic, jc] : {std::array{3, 9}, std::array{9, 3}, std::array{0, 12}, std::array{2, 2}}) {
        corner.reset();
        const DeformTable small = DeformTable::create(ellipse(4, 2, 0.3f, 7)).value();
        ASSERT_TRUE(
            deform(corner, small, lift(static_cast<std::uint32_t>(ic) * side + static_cast<std::uint32_t>(jc))).ok());
        for (int i = 1; i < 25; ++i)
            for (int j = 1; j < 25; ++j) {
                // The kernel's own distance decides among the places in the window.
                double want = 0;
                for (const auto& [x, y] : {std::array{i, j}, std::array{-j, i}, std::array{j, -i}, std::array{-i, -j}})
                    if (std::abs(x - ic) < 7 && std::abs(y - jc) < 7)
                        want = std::max(want, ellipse_at(x - ic, y - jc, 4, 2, 0.3));
                ASSERT_NEAR(corner.positions().z[i * 25 + j], want, 1e-6) << ic << ' ' << jc << ": " << i << ' ' << j;
            }
    }
}

TEST(Kernels, UserTableIsLinearBetweenItsValues) {
    const std::vector<float> cone{1, 0.5f, -0.25f, 0};  // at distances 0, 3, 6, 9
    KernelOptions k;
    k.shape = KernelShape::User;
    k.reach = 9;
    k.values = cone;
    const DeformTable t = DeformTable::create(k).value();
    EXPECT_EQ(t.weight(0, 0), 1.0f);
    EXPECT_NEAR(t.weight(3, 0), 0.5, 1e-7);
    EXPECT_NEAR(t.weight(0, -2), 1 - 0.5 * 2 / 3, 1e-6);
    EXPECT_NEAR(t.weight(3, 4), 0.5 - 0.75 * 2 / 3, 1e-6);
    EXPECT_NEAR(t.weight(0, 6), -0.25, 1e-6);
    EXPECT_EQ(t.weight(8, 8), 0.0f);
    const auto code = [&](const std::vector<float>& values) {
        k.values = values;
        return DeformTable::create(k).error().code;
    };
    EXPECT_EQ(code({}), ErrorCode::BadArgument);
    EXPECT_EQ(code({1}), ErrorCode::BadArgument);
    EXPECT_EQ(code({1, 2}), ErrorCode::BadArgument);
    EXPECT_EQ(code({1, NAN}), ErrorCode::BadArgument);
    EXPECT_EQ(code(std::vector<float>(70000, 0.5f)), ErrorCode::BadArgument);
    EXPECT_EQ(DeformTable::create(ellipse(0, 1, 0, 5)).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(DeformTable::create(ellipse(1, NAN, 0, 5)).error().code, ErrorCode::BadArgument);
    EXPECT_EQ(DeformTable::create(ellipse(1, 1, INFINITY, 5)).error().code, ErrorCode::BadArgument);
}

TEST(Kernels, ProfileKeepsItsBound) {
    for (const KernelEnd end : {KernelEnd::Printed, KernelEnd::Compact})
        for (const float sigma : {2.0f, 30.0f, 4000.0f}) {
            KernelOptions k;
            k.sigma = sigma;
            k.reach = 23;
            k.end = end;
            const DeformTable t = DeformTable::create(k).value();
            EXPECT_LT(t.profile_error_bound(), 2e-4f);
            const double R2 = 23.0 * 23 / double{sigma}, rim = std::exp(-R2);
            double worst = 0;
            for (double r = 0; r < 23; r += 0.00713) {
                const double q = r * r / double{sigma};
                const double want = end == KernelEnd::Printed
                                        ? std::exp(-q)
                                        : (std::exp(-q) - rim * (1 + R2 - q)) / (1 - rim * (1 + R2));
                worst = std::max(worst, std::fabs(double{t.profile(static_cast<float>(r))} - want));
            }
            EXPECT_LE(worst, double{t.profile_error_bound()}) << sigma;
            EXPECT_EQ(t.profile(1e30f), 0.0f);
            EXPECT_EQ(t.profile(-1), 0.0f);
        }
}

/// Layers with stiffness k(i, j) and mobility f(i, j).
ChartSpec painted(std::uint32_t n, const std::function<float(int, int)>& k, const std::function<float(int, int)>& f,
                  const SeamPairs& seams = {}) {
    ChartSpec c = grid_chart(n, n, flat, seams);
    std::vector<float> deformation, contact;
    for (int i = 0; i < int(n); ++i)
        for (int j = 0; j < int(n); ++j) {
            deformation.insert(deformation.end(), {1, 0, 1, k(i, j)});
            contact.insert(contact.end(), {1, f(i, j)});
        }
    c.add("deformation", ElementType::kF32, {n, n, 4}, deformation);
    c.add("contact", ElementType::kF32, {n, n, 2}, contact);
    return c;
}

TEST(Kernels, StiffnessScalesSigmaAndMobilityTheDisplacement) {
    const auto k = [](int i, int) { return i < 15 ? 0.25f : i == 20 ? 0.0f : 1.0f; };
    const auto f = [](int, int j) { return j < 10 ? 0.0f : j == 12 ? 0.5f : 1.0f; };
    State state = make_state(painted(31, k, f));
    KernelOptions kernel;
    kernel.sigma = 25;
    kernel.reach = 9;
    const DeformTable t = DeformTable::create(kernel).value();
    ASSERT_TRUE(deform(state, t, lift(15 * 31 + 14)).ok());
    for (int i = 0; i < 31; ++i)
        for (int j = 0; j < 31; ++j) {
            const double d2 = (i - 15) * (i - 15) + (j - 14) * (j - 14);
            double want = 0;
            if (std::abs(i - 15) < 9 && std::abs(j - 14) < 9 && k(i, j) > 0)
                want = std::exp(-d2 / (25.0 * double{k(i, j)})) * double{f(i, j)};
            ASSERT_NEAR(state.positions().z[i * 31 + j], want, 2e-6) << i << ' ' << j;
        }
    const auto code = [&](float stiffness, float mobility) {
        const ChartSpec c = painted(
            5, [&](int i, int) { return i == 2 ? stiffness : 1.0f; },
            [&](int i, int) { return i == 2 ? mobility : 1.0f; });
        return State::create(Opened(build({c})).chart()).error().code;
    };
    EXPECT_EQ(code(1, 1), ErrorCode::Ok);
    EXPECT_EQ(code(NAN, 1), ErrorCode::BadValue);
    EXPECT_EQ(code(1, -0.5f), ErrorCode::BadValue);
    EXPECT_EQ(code(2, 1), ErrorCode::BadValue);
}

TEST(Kernels, PaintedSeamsStayClosed) {
    // Copies painted differently: the representative decides.
    const std::uint32_t n = 21;
    const auto paint = [](int i, int j) { return j == 20 ? 0.3f : 0.2f + 0.03f * static_cast<float>(i); };
    State state = make_state(painted(n, paint, paint, tube_seams(n, n)));
    const DeformTable t = DeformTable::create(ellipse(5, 3, 0.6f, 6)).value();
    for (std::uint32_t s = 0; s < n * n; s += 3) {
        ASSERT_TRUE(deform(state, t, lift(s)).ok());
        for (std::uint32_t i = 0; i < n; ++i)
            ASSERT_TRUE(same_bits(state.positions()[i * n], state.positions()[i * n + n - 1])) << s;
    }
}

}  // namespace
}  // namespace dgm::test
