// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/libdgm/portable_math_test.cpp
// True values were worked out with 160 decimal digits (Python's decimal) and rounded once.
#include "base/portable_math.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace dgm::detail {
namespace {

double ulp(double v) {
    const double size = std::fabs(v);
    return std::nextafter(size, std::numeric_limits<double>::infinity()) - size;
}
struct Pair {
    double x, value;
};

TEST(PortableMath, ExponentialOfKnownValues) {
    constexpr Pair kTrue[] = {{0.0, 0x1p+0},
                              {1.0, 0x1.5bf0a8b145769p+1},
                              {-1.0, 0x1.78b56362cef38p-2},
                              {0.5, 0x1.a61298e1e069cp+0},
                              {-0.34657359, 0x1.6a09e669a7145p-1},
                              {1e-10, 0x1.000000006df38p+0},
                              {-20.25, 0x1.b93de1e27ca3bp-30},
                              {-28, 0x1.853f01d6d53bap-41},
                              {100.5, 0x1.fcc37a76f9e76p+144},
                              {-700.125, 0x1.e8cfc0420616bp-1011},
                              {709.5, 0x1.81e9b4b52d0c9p+1023},
                              {-740.25, 0x0.0000000000042p-1022},
                              {-745.0, 0x0.0000000000001p-1022}};
    for (const Pair& p : kTrue) EXPECT_LE(std::fabs(portable_exp(p.x) - p.value), ulp(p.value)) << p.x;
    EXPECT_EQ(portable_exp(0.0), 1.0);
    EXPECT_EQ(portable_exp(-0.0f), 1.0f);
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(portable_exp(-kInfinity), 0.0);
    EXPECT_EQ(portable_exp(-746.0), 0.0);
    EXPECT_EQ(portable_exp(kInfinity), kInfinity);
    EXPECT_EQ(portable_exp(710.0), kInfinity);
    EXPECT_TRUE(std::isnan(portable_exp(std::numeric_limits<double>::quiet_NaN())));
}

TEST(PortableMath, LogarithmOfKnownValues) {
    constexpr Pair kTrue[] = {{2, 0x1.62e42fefa39efp-1},
                              {0.5, -0x1.62e42fefa39efp-1},
                              {0x1.000000006df38p+0, 0x1.b7cdffffa18d8p-34},
                              {0x1.fff2e48e8a71ep-1, -0x1.a3738d2cf1cc2p-14},
                              {0x1.6a09e667f3bcdp+0, 0x1.62e42fefa39f0p-2},
                              {0x1.6a09e667f3bccp-1, -0x1.62e42fefa39f1p-2},
                              {10, 0x1.26bb1bbb55516p+1},
                              {0x1.56e1fc2f8f359p-997, -0x1.5963447f87fb5p+9},
                              {0x0.0000000000001p-1022, -0x1.74385446d71c3p+9},
                              {0x1.fffffffffffffp+1023, 0x1.62e42fefa39efp+9}};
    for (const Pair& p : kTrue) EXPECT_LE(std::fabs(portable_log(p.x) - p.value), ulp(p.value)) << p.x;
    EXPECT_EQ(portable_log(1), 0.0);
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(portable_log(0), -kInfinity);
    EXPECT_EQ(portable_log(kInfinity), kInfinity);
    EXPECT_TRUE(std::isnan(portable_log(-1)));
    EXPECT_TRUE(std::isnan(portable_log(std::numeric_limits<double>::quiet_NaN())));
}

TEST(PortableMath, PowersOfKnownValues) {
    EXPECT_EQ(portable_pow(1, 3.5), 1.0);
    EXPECT_EQ(portable_pow(7, 0), 1.0);
    EXPECT_NEAR(portable_pow(2, 3), 8, 4e-15);
    EXPECT_NEAR(portable_pow(0.25, 2.5), 0.03125, 3e-17);
    EXPECT_NEAR(portable_pow(1e10, 8) / 1e80, 1, 186 * 2.3e-16) << "|y log x| units more";
}

TEST(PortableMath, SineAndCosineOfKnownAngles) {
    struct Angle {
        float at;
        double sine, cosine;
    };
    // Floats next to multiples of pi/2 are the hard ones, and the large ones.
    constexpr Angle kTrue[] = {{0x1p-1f, 0x1.eaee8744b05f0p-2, 0x1.c1528065b7d50p-1},
                               {0x1.91eb86p-1f, 0x1.69e4fe1908b92p-1, 0x1.6a2ecaf40f8ddp-1},
                               {0x1.921fb6p-1f, 0x1.6a09e6ecb41fep-1, 0x1.6a09e5e333598p-1},
                               {0x1.921fb6p+0f, 0x1.ffffffffffff7p-1, -0x1.777a5cf72ceccp-25},
                               {-0x1p+1f, -0x1.d18f6ead1b446p-1, -0x1.aa22657537205p-2},
                               {0x1.921fb6p+1f, -0x1.777a5cf72cec6p-24, -0x1.fffffffffffdep-1},
                               {0x1.6p+4f, -0x1.220a29f6eb9f4p-7, -0x1.fffadd8d4acdap-1},
                               {0x1.63p+8f, -0x1.f9bd0307d1de3p-16, -0x1.fffffffc18e4cp-1},
                               {0x1.86ap+16f, 0x1.24daa9c527e96p-5, -0x1.ffac3841b3da7p-1},
                               {-0x1.97742p+41f, -0x1.e8510c790f065p-2, -0x1.c208bd44d7148p-1},
                               {0x1.0f0cfp+73f, -0x1.77d988f563719p-1, 0x1.5baded759a40dp-1},
                               {0x1p+100f, -0x1.be8ed97ac1f59p-1, 0x1.f4eb3ff66e36dp-2},
                               {0x1.fffffep+127f, -0x1.0b33665089575p-1, 0x1.b4bf2c79bdfcep-1}};
    for (const Angle& a : kTrue) {
        const SineCosine got = portable_sine(a.at);
        EXPECT_NEAR(got.sine, a.sine, 3e-16) << a.at;
        EXPECT_NEAR(got.cosine, a.cosine, 3e-16) << a.at;
    }
    EXPECT_EQ(portable_sine(0).sine, 0.0);
    EXPECT_EQ(portable_sine(0).cosine, 1.0);
    EXPECT_EQ(portable_sine(1e-30f).sine, 1e-30f);
}

// WebAssembly's C library works its long doubles out as doubles.
#if !defined(__wasm__)
TEST(PortableMath, NeverFarFromTheCLibrary) {
    std::mt19937_64 random(20);
    std::uniform_real_distribution<double> wide(-708, 709), near(-3, 3), angle(-100, 100);
    double exp_error = 0, log_error = 0, sine_error = 0;
    for (int k = 0; k < 200000; ++k) {
        const double x = k % 2 == 0 ? wide(random) : near(random), e = portable_exp(x);
        const long double exact = std::exp(static_cast<long double>(x));
        exp_error = std::fmax(exp_error, static_cast<double>(std::fabs(e - exact)) / ulp(static_cast<double>(exact)));
        const long double log_exact = std::log(static_cast<long double>(e));
        log_error = std::fmax(log_error, static_cast<double>(std::fabs(portable_log(e) - log_exact)) /
                                             ulp(static_cast<double>(log_exact)));
        const auto a = static_cast<float>(angle(random));
        const SineCosine s = portable_sine(a);
        sine_error = std::fmax(sine_error, std::fabs(s.sine - std::sin(double{a})));
        sine_error = std::fmax(sine_error, std::fabs(s.cosine - std::cos(double{a})));
    }
    EXPECT_LT(exp_error, 1.01);
    EXPECT_LT(log_error, 1.01);
    EXPECT_LT(sine_error, 4e-16) << "the library's own error included";
}
#endif

}  // namespace
}  // namespace dgm::detail
