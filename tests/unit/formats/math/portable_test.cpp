// SPDX-License-Identifier: GPL-3.0-or-later
// tests/unit/formats/math/portable_test.cpp
// True values were worked out with 400 bits and rounded once.
#include "math/portable.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace dgm::math {
namespace {
constexpr double kInfinity = std::numeric_limits<double>::infinity(), kNaN = std::numeric_limits<double>::quiet_NaN();

double ulp(double v) {
    const double size = std::fabs(v);
    return std::nextafter(size, kInfinity) - size;
}
struct Known {
    double x, value;
};
struct KnownOfTwo {
    double x, y, value;
};

template <class Function, std::size_t kCount>
void expect_known(Function function, const Known (&known)[kCount]) {
    for (const Known& k : known) EXPECT_LE(std::fabs(function(k.x) - k.value), ulp(k.value)) << k.x;
}
template <class Function, std::size_t kCount>
void expect_known(Function function, const KnownOfTwo (&known)[kCount]) {
    for (const KnownOfTwo& k : known)
        EXPECT_LE(std::fabs(function(k.x, k.y) - k.value), ulp(k.value)) << k.x << " " << k.y;
}

TEST(Portable, KnownValuesOfExponentials) {
    constexpr Known kExp[] = {{0x1p+0, 0x1.5bf0a8b145769p+1},
                              {-0x1p+0, 0x1.78b56362cef38p-2},
                              {0x1p-1, 0x1.a61298e1e069cp+0},
                              {-0x1.62e42fead449cp-2, 0x1.6a09e669a7145p-1},
                              {0x1.b7cdfd9d7bdbbp-34, 0x1.000000006df38p+0},
                              {-0x1.4400000000000p+4, 0x1.b93de1e27ca3bp-30},
                              {0x1.9200000000000p+6, 0x1.fcc37a76f9e76p+144},
                              {-0x1.5e10000000000p+9, 0x1.e8cfc0420616bp-1011},
                              {0x1.62c0000000000p+9, 0x1.81e9b4b52d0c9p+1023},
                              {-0x1.7220000000000p+9, 0x0.0000000000042p-1022}};
    expect_known(exp, kExp);
    EXPECT_EQ(exp(0), 1);
    EXPECT_EQ(exp(-kInfinity), 0);
    EXPECT_EQ(exp(-746), 0);
    EXPECT_EQ(exp(710), kInfinity);
    EXPECT_TRUE(std::isnan(exp(kNaN)));
    constexpr KnownOfTwo kPow[] = {{0x1p+1, 0x1p-1, 0x1.6a09e667f3bcdp+0},
                                   {0x1.8000000000000p+0, -0x1.3333333333333p+1, 0x1.82f92653cc643p-2},
                                   {0x1.47ae147ae147bp-7, 0x1.aaaaaaaaaaaabp-2, 0x1.2c9af449393ffp-3},
                                   {0x1.4000000000000p+3, 0x1.2c00000000000p+8, 0x1.7e43c8800759cp+996},
                                   {0x1.4000000000000p+3, -0x1.3600000000000p+8, 0x0.012688b70e62bp-1022},
                                   {0x1.ff7ced916872bp-1, 0x1.86a1000000000p+15, 0x1.c6980fe1631a0p-73},
                                   {0x1.7e43c8800759cp+996, -0x1.028f5c28f5c29p+0, 0x1.5f1ca8205119dp-1007},
                                   {0x1.8000000000000p+1, 0x1.5555555555555p-2, 0x1.7137449123ef6p+0}};
    expect_known(pow, kPow);
}

TEST(Portable, PowersAtTheEnds) {
    EXPECT_EQ(pow(kNaN, 0), 1);
    EXPECT_EQ(pow(1, kNaN), 1);
    EXPECT_EQ(pow(1, 1e308), 1);
    EXPECT_EQ(pow(0, 2), 0);
    EXPECT_EQ(pow(0, -2), kInfinity);
    EXPECT_EQ(pow(kInfinity, 0.5), kInfinity);
    EXPECT_EQ(pow(kInfinity, -0.5), 0);
    EXPECT_EQ(pow(0.5, 1e308), 0);
    EXPECT_EQ(pow(2, 1e308), kInfinity);
    EXPECT_EQ(pow(2, -kInfinity), 0);
    EXPECT_TRUE(std::isnan(pow(-1, 2)));
    EXPECT_TRUE(std::isnan(pow(2, kNaN)));
    for (int k = -1074; k < 1024; ++k) EXPECT_EQ(pow(2, k), std::ldexp(1, k));
    for (double x = 1; x < 2000; ++x) EXPECT_EQ(pow(x, 2), x * x);
}

TEST(Portable, KnownValuesOfLogarithms) {
    constexpr Known kLog[] = {{0x1p+1, 0x1.62e42fefa39efp-1},
                              {0x1p-1, -0x1.62e42fefa39efp-1},
                              {0x1.ff7ced916872bp-1, -0x1.064670d979b73p-10},
                              {0x1.00068db8bac71p+0, 0x1.a368d0657fcd4p-14},
                              {0x1.6a09e667f3bcdp+0, 0x1.62e42fefa39f0p-2},
                              {0x1.6a09e667f3bccp-1, -0x1.62e42fefa39f1p-2},
                              {0x1.4000000000000p+3, 0x1.26bb1bbb55516p+1},
                              {0x1.56e1fc2f8f359p-997, -0x1.5963447f87fb5p+9},
                              {0x0.0000000000001p-1022, -0x1.74385446d71c3p+9},
                              {0x1.fffffffffffffp+1023, 0x1.62e42fefa39efp+9}};
    expect_known(log, kLog);
    constexpr Known kLog2[] = {{0x1.8000000000000p+1, 0x1.95c01a39fbd68p+0},
                               {0x1.ff7ced916872bp-1, -0x1.7a6210ffb7151p-10},
                               {0x1.f400000000000p+9, 0x1.3ee7b471b3a95p+3},
                               {0x1.4f8b588e368f1p-17, -0x1.09c1165ec0627p+4}};
    expect_known(log2, kLog2);
    constexpr Known kLog10[] = {{0x1p+1, 0x1.34413509f79ffp-2},
                                {0x1p-1, -0x1.34413509f79ffp-2},
                                {0x1.ff7ced916872bp-1, -0x1.c79e5dbf022b6p-12},
                                {0x1.f400000000000p+9, 0x1.8000000000000p+1},
                                {0x1.4f8b588e368f1p-17, -0x1.4000000000000p+2},
                                {0x1.81cd6c8b43958p+13, 0x1.05db618083a9ep+2}};
    expect_known(log10, kLog10);
    for (const auto function : {log, log2, log10}) {
        EXPECT_EQ(function(1), 0);
        EXPECT_EQ(function(0), -kInfinity);
        EXPECT_EQ(function(kInfinity), kInfinity);
        EXPECT_TRUE(std::isnan(function(-1)));
        EXPECT_TRUE(std::isnan(function(kNaN)));
    }
    for (int k = -1074; k < 1024; ++k) EXPECT_EQ(log2(std::ldexp(1, k)), k);
    double power = 1;
    for (int k = 0; k < 23; ++k, power *= 10) EXPECT_EQ(log10(power), k);
}

TEST(Portable, KnownValuesOfSines) {
    constexpr Known kSine[] = {{0x1p-1, 0x1.eaee8744b05f0p-2},
                               {0x1.91eb851eb851fp-1, 0x1.69e4fd79ac743p-1},
                               {0x1.921fb54442d18p-1, 0x1.6a09e667f3bccp-1},
                               {0x1.921fb54442d18p+0, 0x1p+0},
                               {0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53},
                               {-0x1p+1, -0x1.d18f6ead1b446p-1},
                               {0x1.9100000000000p+6, -0x1.1bf00980dc35cp-2},
                               {0x1.e847f00000000p+19, -0x1.833357b1489f3p-1}};
    expect_known(sin, kSine);
    constexpr Known kCosine[] = {{0x1p-1, 0x1.c1528065b7d50p-1},
                                 {0x1.91eb851eb851fp-1, 0x1.6a2ecb934b59ap-1},
                                 {0x1.921fb54442d18p-1, 0x1.6a09e667f3bcdp-1},
                                 {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54},
                                 {0x1.921fb54442d18p+1, -0x1p+0},
                                 {-0x1p+1, -0x1.aa22657537205p-2},
                                 {0x1.9100000000000p+6, 0x1.ebec72ba6b0ecp-1},
                                 {0x1.e847f00000000p+19, 0x1.4efdfc640fc4dp-1}};
    expect_known(cos, kCosine);
    EXPECT_EQ(cos(0), 1);
    EXPECT_TRUE(std::signbit(sin(-0.0)));
    EXPECT_EQ(sin(1e-300), 1e-300);
    EXPECT_NEAR(sin(3e6), std::sin(3e6), 3e6 * 5e-17);
    EXPECT_TRUE(std::isnan(sin(kInfinity)) && std::isnan(cos(kNaN)));
    EXPECT_NEAR(tan(0.75), std::tan(0.75), 2 * ulp(0.9));
}

TEST(Portable, KnownAngles) {
    constexpr KnownOfTwo kAngle[] = {{0x1p+0, 0x1p+1, 0x1.dac670561bb4fp-2},
                                     {-0x1p+0, 0x1p+1, -0x1.dac670561bb4fp-2},
                                     {0x1p+0, -0x1p+1, 0x1.56c6e7397f5aep+1},
                                     {0x1.8000000000000p+1, 0x1p+0, 0x1.3fc176b7a8560p+0},
                                     {-0x1.8000000000000p+1, -0x1p+0, -0x1.e47df3d0dd4d1p+0},
                                     {0x1.56e1fc2f8f359p-997, 0x1.2a05f20000000p+33, 0x0.012688b70e62bp-1022},
                                     {0x1.4e718d7d7625ap+664, 0x1.87e92154ef7acp-665, 0x1.921fb54442d18p+0},
                                     {0x1p-3, 0x1p+0, 0x1.fd5ba9aac2f6ep-4},
                                     {0x1p+0, 0x1p+0, 0x1.921fb54442d18p-1},
                                     {0x1.fae147ae147aep-1, 0x1p+0, 0x1.8f8d0f7321467p-1},
                                     {0x0.0000000000001p-1022, -0x1p+0, 0x1.921fb54442d18p+1},
                                     {0x0.012688b70e62bp-1022, 0x0.03739a252b281p-1022, 0x1.4978fa3269ee1p-2}};
    expect_known(atan2, kAngle);
    for (const double y : {0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity})
        for (const double x : {0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity}) {
            EXPECT_EQ(atan2(y, x), std::atan2(y, x)) << y << " " << x;
            EXPECT_EQ(std::signbit(atan2(y, x)), std::signbit(y));
        }
    EXPECT_TRUE(std::isnan(atan2(kNaN, 1)) && std::isnan(atan2(1, kNaN)));
    constexpr Known kArc[] = {{0x0p+0, 0x1.921fb54442d18p+0},
                              {0x1p-1, 0x1.0c152382d7366p+0},
                              {-0x1p-1, 0x1.0c152382d7366p+1},
                              {0x1.ffffde7210be9p-1, 0x1.72ba46065af16p-10},
                              {-0x1.ffffde7210be9p-1, 0x1.91f15dfb82062p+1},
                              {0x1.6a0902de00d1bp-1, 0x1.9220f70dbbd73p-1}};
    expect_known(acos, kArc);
    EXPECT_EQ(acos(1), 0);
    EXPECT_EQ(acos(-1), 0x1.921fb54442d18p+1);
    EXPECT_TRUE(std::isnan(acos(1.0000001)) && std::isnan(acos(kNaN)));
}

TEST(Portable, Hypotenuses) {
    EXPECT_EQ(hypot(3, -4), 5);
    EXPECT_EQ(hypot(2, -3, 6), 7);
    EXPECT_EQ(hypot(3e300, 4e300), 5e300);
    EXPECT_NEAR(hypot(3e-310, 4e-310), 5e-310, 1e-323);
    EXPECT_EQ(hypot(0, 0, 5e-324), 5e-324);
    EXPECT_EQ(hypot(0, 0), 0);
    EXPECT_EQ(hypot(kInfinity, kNaN), kInfinity);
    EXPECT_TRUE(std::isnan(hypot(1, kNaN)));
}

/// The largest error in units in the last place over random arguments.
class Errors {
 public:
    explicit Errors(unsigned seed) : random_(seed) {}
    double between(double a, double b) { return a + (b - a) * static_cast<double>(random_() >> 11) * 0x1p-53; }
    template <class Got, class True>
    double largest(double low, double high, Got got, True truth) {
        double worst = 0;
        for (int k = 0; k < 100000; ++k) {
            const double x = between(low, high);
            const long double exact = truth(static_cast<long double>(x));
            const auto error = static_cast<double>(std::fabs(got(x) - exact)) / ulp(static_cast<double>(exact));
            worst = std::fmax(worst, error);
        }
        return worst;
    }

 private:
    std::mt19937_64 random_;
};

// The bounds of the header. A long double has 11 bits more, on x86; elsewhere 60 more.
TEST(Portable, ErrorsAreWhatTheHeaderSays) {
    using Long = long double;
    Errors e(7);
    EXPECT_LT(e.largest(-700, 709, exp, [](Long x) { return std::exp(x); }), 0.8);
    EXPECT_LT(e.largest(-1, 1, exp, [](Long x) { return std::exp(x); }), 0.8);
    EXPECT_LT(e.largest(0.5, 2, log, [](Long x) { return std::log(x); }), 0.52);
    EXPECT_LT(e.largest(1e-3, 1e3, log2, [](Long x) { return std::log2(x); }), 0.52);
    EXPECT_LT(e.largest(1e-3, 1e3, log10, [](Long x) { return std::log10(x); }), 0.52);
    EXPECT_LT(e.largest(-7, 7, sin, [](Long x) { return std::sin(x); }), 0.85);
    EXPECT_LT(e.largest(-7, 7, cos, [](Long x) { return std::cos(x); }), 0.85);
    EXPECT_LT(e.largest(-1.5, 1.5, tan, [](Long x) { return std::tan(x); }), 2.1);
    EXPECT_LT(e.largest(-1, 1, acos, [](Long x) { return std::acos(x); }), 1.7);
    const auto angle = [](double x) { return atan2(x, 0.75); };
    EXPECT_LT(e.largest(-3, 3, angle, [](Long x) { return std::atan2(x, Long{0.75}); }), 0.6);
    const auto third = [](double x) { return pow(x, 1 / 3.0); };
    EXPECT_LT(e.largest(0, 1000, third, [](Long x) { return std::pow(x, Long{1 / 3.0}); }), 0.75);
    const auto steep = [](double x) { return pow(x, 5000.5); };
    EXPECT_LT(e.largest(0.9, 1.1, steep, [](Long x) { return std::pow(x, Long{5000.5}); }), 0.75);
    const auto far = [](double x) { return hypot(x, 0.7, -0.3); };
    EXPECT_LT(e.largest(-2, 2, far, [](Long x) { return std::hypot(x, Long{0.7}, Long{-0.3}); }), 1.4);
}

TEST(Portable, SameBitsEverywhere) {
    Errors e(11);
    std::uint64_t hash = 14695981039346656037u;  // FNV-1a over words
    const auto add = [&](double value) { hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 1099511628211u; };
    for (int k = 0; k < 20000; ++k) {
        const double x = e.between(-30, 30), y = e.between(1e-6, 50);
        for (const double value : {exp(x), log(y), log2(y), log10(y), pow(y, x), sin(x), cos(1e4 * x), tan(x),
                                   atan2(x, y), acos(x / 30), hypot(x, y), hypot(x, y, 1)})
            add(value);
    }
    EXPECT_EQ(hash, 10568649310977553704u);
}

}  // namespace
}  // namespace dgm::math
