// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/cloth_forms_test.cpp
// Cloth at rest against solutions that are worked out here without the model: by formula, bisection or shooting.
#include <algorithm>
#include <cmath>

#include "cloth_shapes.h"

namespace dgm::test {
namespace {

using detail::Double3;

class Hanging : public testing::TestWithParam<int> {};
TEST_P(Hanging, SheetStretchesByItsWeight) {
    // Tension at height z is rho g (L - z): the lower end sinks by rho g L^2 / (2 E t).
    const auto n = static_cast<std::uint32_t>(GetParam());
    for (const float modulus : {500.0f, 2e4f}) {
        ClothOptions o;
        o.fabric = {.warp = modulus, .weft = modulus, .shear = 0.3f * modulus, .damping = 2};
        Drape d(curtain_chart(n, n, 1, 1), o);
        d.pin_rows(0, 1);
        d.how.substeps = 1;
        const double before = -d.mean_of_row(n - 1).z;
        d.run(n > 100 ? 90 : 240);
        const double stretch = -d.mean_of_row(n - 1).z - before;
        const double exact = 0.2 * double{kG} / (2 * double{modulus});
        EXPECT_NEAR(stretch, exact, 0.01 * exact) << n << ' ' << modulus;
        EXPECT_NEAR(stretch, exact, 1e-3);
    }
}
INSTANTIATE_TEST_SUITE_P(Sizes, Hanging, testing::Values(33, 65, 129));
// The same at 257 x 257 takes half a minute without vectors.
INSTANTIATE_TEST_SUITE_P(Large, Hanging, testing::Values(257));

TEST(ClothForms, WarpAndWeftHaveTheirOwnModuli) {
    for (const bool along : {true, false}) {
        ClothOptions o;
        o.fabric = {.warp = 300, .weft = 3000, .shear = 100, .damping = 2};
        const std::uint32_t n = 33;
        Drape d(along ? curtain_chart(n, n, 1, 1)
                      : grid_chart(n, n,
                                   [](double i, double j) {
                                       return Point{float(i / 32), 0, float(-j / 32)};
                                   }),
                o);
        for (std::uint32_t k = 0; k < n; ++k) d.pin(along ? k : k * n);
        d.run(300);
        Double3 sum;
        for (std::uint32_t k = 0; k < n; ++k) sum = sum + (along ? d.at(n - 1, k) : d.at(k, n - 1));
        const double exact = 0.2 * double{kG} / (2 * (along ? 300 : 3000));
        EXPECT_NEAR(-sum.z / n - 1, exact, 0.01 * exact);
    }
}

TEST(ClothForms, StripBetweenTwoRodsIsACatenary) {
    // Length 1 between supports 0.7 apart: 2 a sinh(0.35 / a) = 1, sag a (cosh(0.35 / a) - 1).
    double low = 0.05, high = 10;
    for (int k = 0; k < 200; ++k) {
        const double a = (low + high) / 2;
        (2 * a * std::sinh(0.35 / a) > 1 ? low : high) = a;
    }
    const double sag = low * (std::cosh(0.35 / low) - 1);
    ClothOptions o;
    // Its bending length, (B / rho g)^(1/3), is 2 cm, which changes the sag by 0.1 %.
    o.fabric = {.warp = 2e3f, .weft = 2e3f, .shear = 400, .bending = 1e-5f, .damping = 2};
    Drape d(sheet_chart(65, 9, 1, 0.125), o);
    d.how.cycles = 2;
    d.pin_rows(0, 1);
    d.pin_rows(64, 1);
    for (int k = 1; k <= 30; ++k) {
        for (std::size_t p = 9; p < 18; ++p) d.pins[p].position.x = 1 - 0.3f * float(k) / 30;
        d.run(1);
    }
    d.run(400);
    EXPECT_NEAR(-d.mean_of_row(32).z, sag, 0.01 * sag);
    // And at a quarter of its length: a (cosh((0.35 - x) / a) ...), by the arc length a sinh(x / a) = 0.25 from the
    // middle.
    const double x = low * std::asinh(0.25 / low);
    EXPECT_NEAR(-d.mean_of_row(16).z, sag - low * (std::cosh(x / low) - 1), 0.01 * sag);
    EXPECT_NEAR(d.mean_of_row(16).x, 0.35 - x, 0.01 * 0.7);
}

/// Tip of a heavy elastica of length 1, clamped horizontally: theta'' = gamma (1 - s) cos(theta), theta downwards.
std::pair<double, double> heavy_elastica(double gamma) {
    double low = 0, high = 100, x = 0, z = 0;
    for (int round = 0; round < 100; ++round) {
        const double start = (low + high) / 2;
        double theta = 0, bent = start;
        x = z = 0;
        constexpr int kSteps = 4000;
        for (int k = 0; k < kSteps; ++k) {
            const double h = 1.0 / kSteps, s = (k + 0.5) * h, middle = theta + 0.5 * h * bent;
            const double rate = -gamma * (1 - s) * std::cos(middle);
            x += h * std::cos(middle);
            z -= h * std::sin(middle);
            theta += h * (bent + 0.5 * h * rate);
            bent += h * rate;
        }
        (bent > 0 ? high : low) = start;  // no moment at the tip
    }
    return {x, z};
}

class Cantilever : public testing::TestWithParam<double> {};
TEST_P(Cantilever, IsTheHeavyElastica) {
    const double gamma = GetParam(), length = 0.3, density = 0.2;
    const std::uint32_t rows = 65, cols = 9;
    // Two rows are held: the clamp lies between them.
    const double step = length / (rows - 1), free = length - 0.5 * step;
    ClothOptions o;
    o.fabric.bending = float(density * double{kG} * free * free * free / gamma);
    o.fabric.damping = 2;
    Drape d(sheet_chart(rows, cols, length, cols * step), o);
    d.pin_rows(0, 2);
    d.how.substeps = 1;
    d.run(480);
    const auto [x, z] = heavy_elastica(gamma);
    EXPECT_NEAR(d.mean_of_row(rows - 1).x, 0.5 * step + free * x, 0.01 * length);
    EXPECT_NEAR(d.mean_of_row(rows - 1).z, free * z, std::min(0.01 * length, 0.01 * -free * z)) << "of the sag, too";
}
INSTANTIATE_TEST_SUITE_P(Gamma, Cantilever, testing::Values(0.1, 1.0, 10.0));

/// A flat sheet whose quads are neither rectangles nor alike.
ChartSpec uneven_sheet() {
    return grid_chart(17, 13, [](double i, double j) {
        const double u = i / 16, v = j / 12;
        return Point{float(u + 0.2 * v + 0.05 * std::sin(5 * u + 3 * v)),
                     float(0.8 * v + 0.1 * u * v + 0.03 * std::sin(7 * u)), 0};
    });
}
TEST(ClothForms, AffineMapsOfAnySheetAreInEquilibrium) {
    // Isotropic: warp and weft turn from quad to quad here.
    ClothOptions o;
    o.fabric = {.warp = 2000, .weft = 2000, .cross = 600, .shear = 700, .bending = 1e-3f};
    Drape d(uneven_sheet(), o);
    detail::ClothImpl& c = *d.cloth.impl();
    const double by[3][2] = {{1.1, 0.2}, {-0.1, 0.9}, {0.3, 0.4}};
    for (std::uint32_t k = 0; k < c.total; ++k) {
        const auto s = c.spot_of(k);
        const Double3 x = c.place(s);
        for (int e = 0; e < 3; ++e) c.fine().at[e][s] = by[e][0] * x.x + by[e][1] * x.y;
    }
    static_cast<void>(detail::cloth::evaluate(c));
    detail::cloth::sum_classes(c.fine(), c.gradient.p);
    double border = 0, inside = 0;
    for (std::uint32_t i = 0; i < 17; ++i)
        for (std::uint32_t j = 0; j < 13; ++j) {
            const Double3 f = detail::cloth::at(c.gradient, c.spot_of(i * 13 + j));
            double& most = i == 0 || j == 0 || i == 16 || j == 12 ? border : inside;
            most = std::max(most, std::sqrt(dot(f, f)));
        }
    EXPECT_GT(border, 1);
    EXPECT_LT(inside, 1e-5 * border);
}

TEST(ClothForms, RigidMotionsMeetNoForce) {
    for (const bool curved : {false, true}) {
        ClothOptions o;
        o.fabric.bending = 1e-3f;
        Drape d(curved ? skirt_chart(17, 33, 0.2, 0.4, 0.5) : uneven_sheet(), o);
        detail::ClothImpl& c = *d.cloth.impl();
        const double unit = detail::cloth::evaluate(c);
        EXPECT_LT(unit, 1e-9);
        const Turn turned = turn(1.3);
        for (std::uint32_t k = 0; k < c.total; ++k) {
            const auto s = c.spot_of(k);
            const Double3 x = c.place(s);
            c.fine().at[0][s] = turned.cosine * x.x - turned.sine * x.z + 5;
            c.fine().at[1][s] = x.y - 2;
            c.fine().at[2][s] = turned.sine * x.x + turned.cosine * x.z;
        }
        EXPECT_LT(detail::cloth::evaluate(c), 1e-9);
        double most = 0;
        for (std::uint32_t k = 0; k < c.total; ++k) {
            const Double3 f = detail::cloth::at(c.gradient, c.spot_of(k));
            most = std::max(most, std::sqrt(dot(f, f)));
        }
        EXPECT_LT(most, 1e-6 * 2000 * 0.1);  // of the modulus times a grid step
    }
}

TEST(ClothForms, ForceIsTheSlopeOfTheEnergy) {
    ClothOptions o;
    o.fabric = {.warp = 900, .weft = 500, .cross = 200, .shear = 150, .bending = 1e-3f};
    for (const bool tube : {false, true}) {
        Drape d(tube ? skirt_chart(9, 17, 0.2, 0.4, 0.5) : uneven_sheet(), o);
        detail::ClothImpl& c = *d.cloth.impl();
        for (std::uint32_t k = 0; k < c.total; ++k)
            for (int e = 0; e < 3; ++e)
                c.fine().at[e][c.spot_of(k)] +=
                    0.02 * std::sin(3 * e + 17.0 * (c.fine().own[c.spot_of(k)] != 0 ? k : k / 17 * 17));
        for (const std::uint32_t k : {0u, 20u, 51u, 77u}) {
            static_cast<void>(detail::cloth::evaluate(c));
            detail::cloth::sum_classes(c.fine(), c.gradient.p);
            const Double3 slopes = detail::cloth::at(c.gradient, c.spot_of(k));
            for (int e = 0; e < 3; ++e) {
                const double h = 1e-5, slope = e == 0 ? slopes.x : e == 1 ? slopes.y : slopes.z;
                const auto moved = [&](double by) {
                    detail::cloth::each_copy(c, k, [&](std::uint32_t s) { c.fine().at[e][c.spot_of(s)] += by; });
                    const double energy = detail::cloth::evaluate(c);
                    detail::cloth::each_copy(c, k, [&](std::uint32_t s) { c.fine().at[e][c.spot_of(s)] -= by; });
                    return energy;
                };
                EXPECT_NEAR((moved(h) - moved(-h)) / (2 * h), slope, 1e-2 * std::fabs(slope) + 0.05) << tube << k << e;
            }
        }
    }
}

/// A skirt with twelve pleats that stands off, 22 cm high, and how its grid lies on it.
enum class Grid { Even, Wavy, Sheared };
ChartSpec pleated_chart(Grid grid) {
    const std::uint32_t rows = 33, cols = 129;
    SeamPairs seams;
    for (std::uint32_t i = 0; i < rows; ++i) seams.push_back({i * cols, i * cols + cols - 1});
    constexpr double kTurn = 2 * std::numbers::pi;
    return grid_chart(
        rows, cols,
        [=](double i, double j) {
            double s = i / (rows - 1), t = j == cols - 1 ? 0 : j / (cols - 1);
            const double down = s, around = t;
            if (grid == Grid::Wavy) {
                s += 0.4 * down * (1 - down) * std::sin(kTurn * (2 * around + 0.3));
                t += 0.06 * down + 0.03 * std::sin(1.5 * kTurn * down) * std::cos(kTurn * around);
            }
            // By twenty columns within two rows, where the edges of quads meet at a few degrees.
            const double off = (around - 0.5) / 0.15;
            if (grid == Grid::Sheared) t += 0.08 * (1 + std::tanh(64 * (down - 0.48))) * std::exp(-off * off);
            const double r = 0.11 * (1 + 2 * s) + 0.02 * s * std::cos(12 * kTurn * t);
            return Point{float(r * std::cos(kTurn * t)), float(r * std::sin(kTurn * t)), float(-0.22 * s)};
        },
        seams);
}
/// How far its mean sample sinks in half a second.
double sinks(Grid grid, float modulus) {
    ClothOptions o;
    o.fabric = {.warp = modulus, .weft = modulus, .shear = 0.2f * modulus};
    Drape d(pleated_chart(grid), o);
    for (std::uint32_t k = 0; k < 128; ++k) d.pin(k);
    d.how.substeps = 4;
    d.how.cycles = 4;
    const auto height = [&] {
        double sum = 0;
        for (std::uint32_t i = 0; i < 33; ++i) sum += d.mean_of_row(i).z / 33;
        return sum;
    };
    const double before = height();
    d.run(30);
    return before - height();
}
TEST(ClothForms, FoldsMayCrossTheLinesOfTheGrid) {
    // Chords of such lines change their lengths as a fold moves on. Where that is resisted, the wavy skirt sinks by a
    // millimetre, and the sheared one by two.
    EXPECT_GT(sinks(Grid::Even, 800), 0.02);
    EXPECT_GT(sinks(Grid::Wavy, 800), 0.02);
    EXPECT_GT(sinks(Grid::Even, 100), 0.02);
    EXPECT_GT(sinks(Grid::Sheared, 100), 0.02);
}

TEST(ClothForms, FreeFall) {
    ClothOptions o;
    o.fabric.damping = 0;
    Drape d(sheet_chart(17, 33, 0.5, 1), o);
    const ClothReport r = d.run(60);
    // Implicit Euler: v = g t, z = g t (t + h) / 2.
    EXPECT_NEAR(d.mean_of_row(8).z, -0.5 * double{kG} * (1 + 1.0 / 120), 1e-4);
    EXPECT_LT(r.elastic, 1e-9);
}

}  // namespace
}  // namespace dgm::test
