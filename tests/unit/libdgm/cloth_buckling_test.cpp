// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/cloth_buckling_test.cpp
// Strips that stand on edge, clamped at one end: they lean out by their weight, and buckle beyond a threshold.
//
// The equations are those of [Michell 1899, Prandtl 1899]: with B' = B w and C = 2 B w of a thin strip, M the moment of
// its weight and a load that is tilted by a, B' v'' = M (a + phi), C phi'' = - M v''. Two things of a plate are added:
// a clamp keeps cross-sections flat, which holds the twist for w / sqrt(24) further [Vlasov 1961]; and edgewise bending
// gives way, 1 / B' becomes 1 / B' - 1 / EI, likewise 1 / C [Timoshenko, Gere 1961]. Two rows of samples are held.
// Samples of the second one bend, but only quads beyond it twist, so the clamp of the bending lies half a step before
// that of the twist.
#include <algorithm>
#include <cmath>

#include "cloth_shapes.h"

namespace dgm::test {
namespace {

struct Strip {
    std::uint32_t rows, cols;
    double width;  ///< of the length
    float modulus;
    static constexpr double kLength = 0.3, kDensity = 0.2;
    [[nodiscard]] double step() const { return kLength / (rows - 1); }
    [[nodiscard]] double free() const { return kLength - 0.5 * step(); }
    /// gamma = rho g L^3 / B, L what is free to bend.
    [[nodiscard]] double bending(double gamma) const {
        return kDensity * double{kG} * free() * free() * free() / gamma;
    }
    /// Length over which the twist is held, of the free one.
    [[nodiscard]] double held() const { return (width * kLength / std::sqrt(24.0) + 0.5 * step()) / free(); }
    /// B' / EI
    [[nodiscard]] double give(double gamma) const {
        return 12 * bending(gamma) / (double{modulus} * width * width * kLength * kLength);
    }
    [[nodiscard]] ClothOptions options(double gamma) const {
        ClothOptions o;
        o.fabric.warp = o.fabric.weft = modulus;
        o.fabric.shear = modulus / 2;
        o.fabric.bending = float(bending(gamma));
        o.fabric.damping = 2;
        return o;
    }
    [[nodiscard]] ChartSpec chart() const {
        return grid_chart(rows, cols, [s = *this](double i, double j) {
            return Point{float(s.step() * i), 0, float(s.width * kLength * j / (s.cols - 1))};
        });
    }
};

/// How far the end leans out, over the length, and the twist per length there, if it is `first` at the clamp.
std::pair<double, double> shoot(const Strip& s, double gamma, double tilt, double first) {
    constexpr int kSteps = 8000;
    const double h = 1.0 / kSteps, r = s.give(gamma), held = s.held();
    double v = 0, slope = 0, phi = 0, twist = first;
    for (int k = 0; k < kSteps; ++k) {
        const double at = (k + 0.5) * h, moment = 0.5 * gamma * (1 - at) * (1 - at);
        const bool twists = at >= held;
        const double bent = (1 - r) * moment * (tilt + phi + (twists ? 0.5 * h * twist : 0));
        v += h * (slope + 0.5 * h * bent);
        slope += h * bent;
        if (!twists) continue;
        const double change = -0.5 * (1 - 2 * r) * moment * bent;
        phi += h * (twist + 0.5 * h * change);
        twist += h * change;
    }
    return {v, twist};
}
double lean_of(const Strip& s, double gamma, double tilt) {
    const auto a = shoot(s, gamma, tilt, 0), b = shoot(s, gamma, tilt, 1);
    return a.first - a.second / (b.second - a.second) * (b.first - a.first);
}
/// Gamma at which a strip that is not tilted leaves the plane.
double threshold_of(const Strip& s) {
    double low = 5, high = 40;
    for (int k = 0; k < 60; ++k) {
        const double middle = (low + high) / 2;
        (shoot(s, middle, 0, 1).second > 0 ? low : high) = middle;
    }
    return low;
}
double lean_after(const Strip& s, double gamma, double tilt, int frames, std::uint32_t substeps = 1) {
    Drape d(s.chart(), s.options(gamma));
    d.how.gravity = {0, float(-double{kG} * std::sin(tilt)), float(-double{kG} * std::cos(tilt))};
    d.pin_rows(0, 2);
    d.how.substeps = substeps;
    d.run(frames);
    return -d.mean_of_row(s.rows - 1).y / s.free();
}

TEST(ClothBuckling, TheReferenceIsPrandtls) {
    // A narrow strip that edgewise bending leaves stiff: 12.85 (C / B')^(1/2).
    EXPECT_NEAR(threshold_of({1000001, 3, 1e-4, 1e12f}), 12.85 * std::sqrt(2.0), 0.01);
}

TEST(ClothBuckling, ATwistedStripHoldsTheEnergyOfAPlate) {
    // x = (s, z phi' s, z): C phi'^2 L / 2 with C = 2 B w, whatever the quads.
    for (const std::uint32_t cols : {3u, 6u, 9u}) {
        const Strip s{65, cols, 0.1, 1e-3f};
        const double gamma = 10, twist = 0.1;
        Drape d(s.chart(), s.options(gamma));
        detail::ClothImpl& c = *d.cloth.impl();
        for (std::uint32_t k = 0; k < c.total; ++k) {
            const auto at = c.spot_of(k);
            const detail::Double3 x = c.place(at);
            c.fine().at[1][at] = twist * x.x * x.z;
        }
        const double exact = s.bending(gamma) * s.width * Strip::kLength * twist * twist * Strip::kLength;
        EXPECT_NEAR(detail::cloth::evaluate(c), exact, 1e-3 * exact) << cols;
    }
}

TEST(ClothBuckling, TiltedStripsLeanOutAsTheEquationsSay) {
    const Strip s{129, 9, 0.05, 1e5f};
    for (const double gamma : {8.0, 12.0}) {
        const double exact = lean_of(s, gamma, 0.02);
        EXPECT_NEAR(lean_after(s, gamma, 0.02, 3200), exact, 0.01 * exact) << gamma;
    }
}

TEST(ClothBuckling, NarrowStripsDoNotStandStill) {
    // 1:40, where the smoother's first bound of eigenvalues is too low.
    for (const std::uint32_t cols : {3u, 5u}) {
        const Strip s{65, cols, 0.025, 1e5f};
        const double exact = lean_of(s, 8, 0.02);
        EXPECT_NEAR(lean_after(s, 8, 0.02, 3200), exact, 0.02 * exact) << cols;
    }
}

TEST(ClothBuckling, StripsComeToEquilibriumWhateverTheSolver) {
    // A hundredth of the tilt, and other substeps: nothing stands still before forces balance.
    const Strip s{65, 9, 0.1, 2e5f};
    const double lean = lean_after(s, 12, 0.02, 3200);
    EXPECT_NEAR(lean_after(s, 12, 0.02, 1600, 2), lean, 0.005 * lean);
    EXPECT_NEAR(10 * lean_after(s, 12, 0.002, 3200), lean, 0.01 * lean);
    // Coarser and wider than the equations' strip.
    EXPECT_NEAR(lean, lean_of(s, 12, 0.02), 0.03 * lean);
}

TEST(ClothBuckling, StripsBuckleAtTheThreshold) {
    const Strip s{65, 9, 0.05, 1e5f};
    const double critical = threshold_of(s), tilt = 1e-4;
    EXPECT_LT(lean_after(s, 0.97 * critical, tilt, 6000), 1.2 * lean_of(s, 0.97 * critical, tilt));
    EXPECT_GT(lean_after(s, 1.05 * critical, tilt, 6000), 0.05);
}

}  // namespace
}  // namespace dgm::test
