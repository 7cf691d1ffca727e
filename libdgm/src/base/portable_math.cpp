// SPDX-License-Identifier: MIT
// libdgm/src/base/portable_math.cpp
#include "base/portable_math.h"

namespace dgm::detail {
namespace {
constexpr double kInfinity = __builtin_inf();
constexpr double kLog2E = 0x1.71547652b82fep+0;
// ln 2 = high + low. The high part has 31 bits, so its product with an exponent is exact.
constexpr double kLn2High = 0x1.62e42feep-1, kLn2Low = 0x1.a39ef35793c76p-33;
constexpr double kHalfPi = 0x1.921fb54442d18p+0;

std::uint64_t bits_of(double x) noexcept {
    return __builtin_bit_cast(std::uint64_t, x);
}
/// 2^k for -1022 <= k <= 1023.
double power_of_two(int k) noexcept {
    return __builtin_bit_cast(double, static_cast<std::uint64_t>(k + 1023) << 52);
}
/// x 2^k, rounded once, where the result may be subnormal or infinite; |k| <= 2000.
double scale(double x, int k) noexcept {
    if (k > 1023) return x * 0x1p1023 * power_of_two(k - 1023);
    if (k < -1022) return x * power_of_two(k + 1022) * 0x1p-1022;
    return x * power_of_two(k);
}

struct Reduced {
    double rest;        ///< -pi/4 .. pi/4
    unsigned quadrant;  ///< 0 .. 3
};

/// Bits of 2/pi from place `at` on (place 0 is worth 2^31; the first 32 are 0, as is the integer part).
std::uint32_t word_at(int at) noexcept {
    static constexpr std::uint32_t kTwoOverPi[] = {0,           0xA2F9836Eu, 0x4E441529u, 0xFC2757D1u,
                                                   0xF534DDC0u, 0xDB629599u, 0x3C439041u, 0xFE5163ABu};
    const int word = at / 32, shift = at % 32;
    const std::uint64_t pair = std::uint64_t{kTwoOverPi[word]} << 32 | kTwoOverPi[word + 1];
    return static_cast<std::uint32_t>(pair << shift >> 32);
}

/// Reduces a positive finite angle m 2^e, where m is an integer of 24 bits: multiplies m by the 96 bits of 2^e 2/pi
/// that are worth 2 .. 2^-94. Bits above them make whole turns, those below less than 2^-70.
Reduced reduce(float angle) noexcept {
    if (angle < 0.785f) return {static_cast<double>(angle), 0};
    const auto bits = __builtin_bit_cast(std::uint32_t, angle);
    const int e = static_cast<int>(bits >> 23) - 150, at = e + 30;  // e is -24 at least
    const std::uint64_t m = (bits & 0x7FFFFFu) | 0x800000u;
    const std::uint64_t low = m * word_at(at + 64), middle = m * word_at(at + 32) + (low >> 32);
    const std::uint64_t high = m * word_at(at) + (middle >> 32);
    // Two bits of quadrant, 62 of fraction.
    const std::uint64_t turns = high << 32 | (middle & 0xFFFFFFFFu);
    const std::uint64_t quadrant = (turns + (std::uint64_t{1} << 61)) >> 62;  // to the nearest
    const auto fraction = static_cast<std::int64_t>(turns - (quadrant << 62));
    return {static_cast<double>(fraction) * 0x1p-62 * kHalfPi, static_cast<unsigned>(quadrant)};
}
}  // namespace

double portable_exp(double x) noexcept {
    if (!(x < 709.8)) return x != x ? x : kInfinity;
    if (x < -745.2) return 0;
    const int k = static_cast<int>(x * kLog2E + (x < 0 ? -0.5 : 0.5));
    const double r = (x - k * kLn2High) - k * kLn2Low;  // |r| <= 0.347
    static constexpr double kFactorials[] = {6227020800, 479001600, 39916800, 3628800, 362880, 40320,
                                             5040,       720,       120,      24,      6,      2};
    double p = 0;  // 1/2 + r/3! + r^2/4! ... r^11/13!: what is left is below 2^-57
    for (const double factorial : kFactorials) p = p * r + 1 / factorial;
    return scale(1 + (r + r * r * p), k);
}

double portable_log(double x) noexcept {
    if (!(x > 0)) return x == 0 ? -kInfinity : __builtin_nan("");
    if (x == kInfinity) return x;
    int k = 0;
    if (x < 0x1p-1022) {
        x *= 0x1p54;
        k = -54;
    }
    k += static_cast<int>(bits_of(x) >> 52) - 1023;
    double m = __builtin_bit_cast(double, (bits_of(x) & 0xFFFFFFFFFFFFFu) | 0x3FF0000000000000u);
    if (m > 1.4142135623730951) {
        m *= 0.5;
        ++k;
    }
    // log(1 + f) = 2 atanh(s) = f - s (f - R), s = f / (2 + f), R = s^2 (2/3 + 2/5 s^2 + ...): |s| <= 0.172, what is
    // left is below 2^-58.
    const double f = m - 1, s = f / (2 + f), s2 = s * s;
    double p = 0;
    for (int n = 23; n >= 3; n -= 2) p = p * s2 + 2.0 / n;
    const double minus = s * (f - s2 * p);
    return k * kLn2High + (f - (minus - k * kLn2Low));
}

SineCosine portable_sine(float angle) noexcept {
    const Reduced a = reduce(angle < 0 ? -angle : angle);
    const double r = a.rest, r2 = r * r;
    double s = 0, c = 0;  // sine = r - r^3 s, cosine = 1 - r^2 c; what is left is below 2^-58
    for (int n = 16; n >= 2; n -= 2) s = (1 - r2 * s) / (n * (n + 1));
    for (int n = 17; n >= 1; n -= 2) c = (1 - r2 * c) / (n * (n + 1));
    s = r - r * r2 * s;
    c = 1 - r2 * c;
    const double sine = a.quadrant % 2 == 0 ? s : c, cosine = a.quadrant % 2 == 0 ? c : s;
    const bool turn_sine = (a.quadrant >= 2) != (angle < 0), turn_cosine = a.quadrant == 1 || a.quadrant == 2;
    return {turn_sine ? -sine : sine, turn_cosine ? -cosine : cosine};
}

}  // namespace dgm::detail
