// SPDX-License-Identifier: GPL-3.0-or-later
// formats/math/portable.cpp
#include "math/portable.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace dgm::math {
namespace {
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The sum of two doubles, of which `high` alone is the nearest double.
struct Pair {
    double high, low;
};
constexpr Pair kPi{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
constexpr Pair kLog2E{0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56};
constexpr Pair kLog10E{0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57};
constexpr Pair kThird{0x1.5555555555555p-2, 0x1.5555555555555p-56};
// ln 2: the high part has 31 bits, so its product with an exponent is exact.
constexpr double kLn2High = 0x1.62e42feep-1, kLn2Low = 0x1.a39ef35793c76p-33;
// pi/2 in pieces of 33 bits, exact in products with 20 bits, and the rest.
constexpr double kHalfPi[] = {0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2ep-69, 0x1.b839a252049c1p-104};
constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1;

/// a + b exactly, if |a| >= |b| or a is 0.
Pair ordered_sum(double a, double b) noexcept {
    const double sum = a + b;
    return {sum, b - (sum - a)};
}
/// a + b exactly.
Pair sum(double a, double b) noexcept {
    const double sum = a + b, part = sum - a;
    return {sum, (a - (sum - part)) + (b - part)};
}
/// The upper 26 bits of a number below 2^996, and the rest.
Pair halves(double a) noexcept {
    const double big = 134217729 * a, high = big - (big - a);
    return {high, a - high};
}
/// a b exactly, but for underflow.
Pair product(double a, double b) noexcept {
    const double high = a * b;
    const Pair p = halves(a), q = halves(b);
    return {high, ((p.high * q.high - high) + p.high * q.low + p.low * q.high) + p.low * q.low};
}
/// a b, to some 100 bits.
Pair product(const Pair& a, const Pair& b) noexcept {
    const Pair p = product(a.high, b.high);
    return ordered_sum(p.high, p.low + (a.high * b.low + a.low * b.high));
}
/// a / b, to some 100 bits.
Pair quotient(const Pair& a, const Pair& b) noexcept {
    const double high = a.high / b.high;
    const Pair p = product(high, b.high);
    return ordered_sum(high, (((a.high - p.high) - p.low) + (a.low - high * b.low)) / b.high);
}

/// c[0] + c[1] x + c[2] x^2 ..., the even and the odd powers side by side: they need not wait for each other.
template <std::size_t kCount>
double polynomial(const double (&c)[kCount], double x) noexcept {
    static_assert(kCount % 2 == 0);
    const double x2 = x * x;
    double even = c[kCount - 2], odd = c[kCount - 1];
    for (std::size_t k = kCount - 2; k > 0; k -= 2) {
        even = even * x2 + c[k - 2];
        odd = odd * x2 + c[k - 1];
    }
    return even + x * odd;
}

/// 2^k for -1022 <= k <= 1023.
double power_of_two(int k) noexcept {
    return std::bit_cast<double>(static_cast<std::uint64_t>(k + 1023) << 52);
}
/// x 2^k, where the result may be subnormal or infinite; |k| <= 2000.
double scaled(double x, int k) noexcept {
    if (k > 1023) return x * 0x1p1023 * power_of_two(k - 1023);
    if (k < -1022) return x * power_of_two(k + 1022) * 0x1p-1022;
    return x * power_of_two(k);
}

/// log x of a positive finite number, to some 64 bits: x = 2^k (1 + f), log(1 + f) = 2 atanh s with s = f / (2 + f),
/// |s| <= 0.172.
Pair long_log(double x) noexcept {
    int k = 0;
    if (x < 0x1p-1022) {
        x *= 0x1p54;
        k = -54;
    }
    const auto bits = std::bit_cast<std::uint64_t>(x);
    k += static_cast<int>(bits >> 52) - 1023;
    double m = std::bit_cast<double>((bits & 0xFFFFFFFFFFFFFu) | 0x3FF0000000000000u);
    if (m > 1.4142135623730951) {
        m *= 0.5;
        ++k;
    }
    const double f = m - 1;
    const Pair s = quotient({f, 0}, ordered_sum(2, f)), s2 = product(s, s);
    // atanh s = s + s (s^2 / 3 + s^4 (1/5 + s^2 / 7 + ...)); the bracket is below 0.01, what is left below 2^-66.
    static constexpr double kOdd[] = {1. / 5,  1. / 7,  1. / 9,  1. / 11, 1. / 13, 1. / 15,
                                      1. / 17, 1. / 19, 1. / 21, 1. / 23, 1. / 25, 1. / 27};
    const Pair third = product(s2, kThird);
    const Pair bracket = ordered_sum(third.high, third.low + s2.high * s2.high * polynomial(kOdd, s2.high));
    const Pair more = product(s, bracket);
    const Pair half = ordered_sum(s.high, more.high);
    const Pair whole = sum(k * kLn2High, 2 * half.high);
    return ordered_sum(whole.high, whole.low + (k * kLn2Low + 2 * (half.low + (s.low + more.low))));
}

/// e^(x.high + x.low), |x.high| <= 800.
double exp_of(const Pair& x) noexcept {
    const int k = static_cast<int>(x.high * kLog2E.high + (x.high < 0 ? -0.5 : 0.5));
    const double above = x.high - k * kLn2High, below = k * kLn2Low, r = above - below;  // |r| <= 0.347
    const double r_low = ((above - r) - below) + x.low;
    // r^2 (1/2 + r/3! + r^2/4! ...): what is left is below 2^-57.
    static constexpr double kFactorials[] = {1. / 2,       1. / 6,        1. / 24,        1. / 120,
                                             1. / 720,     1. / 5040,     1. / 40320,     1. / 362880,
                                             1. / 3628800, 1. / 39916800, 1. / 479001600, 1. / 6227020800};
    const double curve = r * r * polynomial(kFactorials, r);
    const Pair linear = ordered_sum(1, r);
    return scaled(linear.high + (linear.low + (curve + r_low * (1 + r + curve))), k);
}

/// The value of a logarithm at the ends of its range; 1 for an argument inside.
double end_of_log(double x) noexcept {
    if (!(x > 0)) return x == 0 ? -kInfinity : kNaN;
    return x == kInfinity ? x : 1;
}

struct ReducedAngle {
    Pair rest;          ///< -pi/4 .. pi/4, and a little
    unsigned quadrant;  ///< 0 .. 3
};
ReducedAngle reduced(double angle) noexcept {
    constexpr double kLargest = 1e6;
    if (std::abs(angle) > kLargest) angle = std::remainder(angle, kPi.high * 2);
    if (!(std::abs(angle) > 0.785)) return {{angle, 0}, 0};
    const double turns = angle * kTwoOverPi;
    const auto k = static_cast<std::int64_t>(turns + (turns < 0 ? -0.5 : 0.5));
    const auto times = static_cast<double>(k);
    // Near a multiple of pi/2 the differences are exact; elsewhere what they lose is kept.
    const Pair first = sum(angle - times * kHalfPi[0], -times * kHalfPi[1]);
    const Pair second = sum(first.high, -times * kHalfPi[2]);
    return {ordered_sum(second.high, second.low + (first.low - times * kHalfPi[3])), static_cast<unsigned>(k & 3)};
}

/// atan(k / 8).
constexpr Pair kAtan[] = {{0, 0},
                          {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
                          {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
                          {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
                          {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
                          {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
                          {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
                          {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
                          {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55}};

/// atan(a / b), 0 <= a <= b, b within 2^+-500: with c = k / 8 near a / b it is atan c + atan((a - c b) / (b + c a)).
Pair atan_of_quotient(double a, double b) noexcept {
    const int k = a < 0.125 * b ? 0 : static_cast<int>(8 * (a / b) + 0.5);
    const double c = 0.125 * k;
    const Pair cb = product(c, b), ca = product(c, a);
    const Pair below = sum(b, ca.high);
    const Pair q = quotient({(a - cb.high) - cb.low, 0}, {below.high, below.low + ca.low});
    const double q2 = q.high * q.high;
    // atan q = q - q^3 (1/3 - q^2 / 5 + ...), |q| <= 1/8; what is left is below 2^-56.
    static constexpr double kOdd[] = {1. / 3, -1. / 5, 1. / 7, -1. / 9, 1. / 11, -1. / 13, 1. / 15, -1. / 17};
    const Pair out = sum(kAtan[k].high, q.high);
    return ordered_sum(out.high, out.low + (kAtan[k].low + (q.low - q.high * q2 * polynomial(kOdd, q2))));
}
/// a - b, where a is the larger.
Pair difference(const Pair& a, const Pair& b) noexcept {
    const Pair out = ordered_sum(a.high, -b.high);
    return ordered_sum(out.high, out.low + (a.low - b.low));
}
/// A power of two that takes a number to where its square is neither huge nor tiny.
double to_middle(double largest) noexcept {
    return largest > 0x1p+500 ? 0x1p-600 : largest < 0x1p-400 ? 0x1p+600 : 1;
}
}  // namespace

double exp(double x) noexcept {
    if (!(x < 709.8)) return x != x ? x : kInfinity;
    return x < -745.2 ? 0 : exp_of({x, 0});
}

double log(double x) noexcept {
    const double end = end_of_log(x);
    return end != 1 ? end : long_log(x).high;
}

double log2(double x) noexcept {
    const double end = end_of_log(x);
    return end != 1 ? end : product(long_log(x), kLog2E).high;
}

double log10(double x) noexcept {
    const double end = end_of_log(x);
    return end != 1 ? end : product(long_log(x), kLog10E).high;
}

double pow(double x, double y) noexcept {
    if (y == 0 || x == 1) return 1;
    if (x != x || y != y || x < 0) return kNaN;
    if (x == 0 || x == kInfinity) return (x == 0) == (y < 0) ? kInfinity : 0;
    const Pair log_x = long_log(x);
    const double about = y * log_x.high;
    if (!(std::abs(about) < 800)) return about > 0 ? kInfinity : 0;
    const Pair exponent = product(y, log_x.high);
    return exp_of(ordered_sum(exponent.high, exponent.low + y * log_x.low));
}

SineCosine sine_cosine(double angle) noexcept {
    if (!std::isfinite(angle)) return {kNaN, kNaN};
    if (angle == 0) return {angle, 1};
    const ReducedAngle a = reduced(angle);
    const double r = a.rest.high, low = a.rest.low, r2 = r * r;
    // sine = r - r^3 s, cosine = 1 - r^2 / 2 + r^4 c; what is left is below 2^-57.
    static constexpr double kOdd[] = {1. / 6,        -1. / 120,        1. / 5040,          -1. / 362880,
                                      1. / 39916800, -1. / 6227020800, 1. / 1307674368000, -1. / 355687428096000};
    static constexpr double kEven[] = {1. / 24,        -1. / 720,         1. / 40320,          -1. / 3628800,
                                       1. / 479001600, -1. / 87178291200, 1. / 20922789888000, -1. / 6402373705728000};
    const double s = polynomial(kOdd, r2), c = polynomial(kEven, r2);
    const double half = 0.5 * r2;
    const Pair less = ordered_sum(1, -half), square = product(r, r);
    const double sine = r - (r2 * r * s - (low - low * half));
    const double cosine = less.high + (less.low - 0.5 * square.low + (r2 * r2 * c - r * low));
    const bool swapped = a.quadrant % 2 == 1, minus = a.quadrant >= 2;
    const double first = swapped ? cosine : sine, second = swapped ? -sine : cosine;
    return {minus ? -first : first, minus ? -second : second};
}

double atan2(double y, double x) noexcept {
    if (x != x || y != y) return kNaN;
    double a = std::abs(y), b = std::abs(x);
    if (a == kInfinity && b == kInfinity) a = b = 1;
    if (b == kInfinity || (a == 0 && b == 0)) {
        a = 0;
        b = 1;
    }
    if (a == kInfinity) {
        a = 1;
        b = 0;
    }
    const double scale = to_middle(std::max(a, b));
    const bool steep = a > b;
    if (a < 0x1p-30 * b && !std::signbit(x)) return std::copysign(a / b, y);  // a scaled might underflow
    if (steep) std::swap(a, b);
    Pair angle = atan_of_quotient(a * scale, b * scale);
    if (steep) angle = difference({0.5 * kPi.high, 0.5 * kPi.low}, angle);
    if (std::signbit(x)) angle = difference(kPi, angle);
    return std::copysign(angle.high, y);
}

double acos(double x) noexcept {
    return atan2(std::sqrt((1 - x) * (1 + x)), x);
}

double hypot(double x, double y) noexcept {
    return hypot(x, y, 0);
}

double hypot(double x, double y, double z) noexcept {
    const double a = std::abs(x), b = std::abs(y), c = std::abs(z);
    if (a == kInfinity || b == kInfinity || c == kInfinity) return kInfinity;
    const double scale = to_middle(std::max({a, b, c}));
    const double p = a * scale, q = b * scale, r = c * scale;
    return std::sqrt(p * p + q * q + r * r) / scale;
}

}  // namespace dgm::math
