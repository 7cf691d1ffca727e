// SPDX-License-Identifier: MIT
// libdgm/src/base/portable_math.h
// Exponential, logarithm, power and sine that give the same bits on every target. C libraries round theirs each in its
// own way; these are built from IEEE 754 operations (+ - * / and conversions), which leave no choice. So all values of
// a shape use these functions, never <cmath>'s transcendental functions.
//
// It takes binary64 arithmetic rounded operation by operation: no contraction (-ffp-contract=off), no fast-math, no
// x87 registers. An x87 build works, but its last bits are its own.
//
// Errors: exp and log at most 1 unit in the last place of the double, power below 1 + |y log x|; sine and cosine below
// 3e-16. Rounded to float that is half a unit in the float's last place and a millionth of one.
//
// Reduction, then polynomials: [Cody, Waite 1980] for exp and log, [Payne, Hanek 1983] for the angle.
#pragma once
#include <cstdint>

namespace dgm::detail {

/// e^x. 0 below -745.2, infinity above 709.79; NaN for NaN.
[[nodiscard]] double portable_exp(double x) noexcept;
/// e^x, worked out in double and rounded once.
[[nodiscard]] inline float portable_exp(float x) noexcept {
    return static_cast<float>(portable_exp(static_cast<double>(x)));
}
/// Natural logarithm. -infinity for 0, NaN below 0 and for NaN.
[[nodiscard]] double portable_log(double x) noexcept;
/// x^y for x > 0: e^(y log x).
[[nodiscard]] inline double portable_pow(double x, double y) noexcept {
    return portable_exp(y * portable_log(x));
}

struct SineCosine {
    double sine, cosine;
};
/// Sine and cosine of any finite angle in radians.
[[nodiscard]] SineCosine portable_sine(float angle) noexcept;

}  // namespace dgm::detail
