// SPDX-License-Identifier: GPL-3.0-or-later
// formats/math/portable.h
// Elementary functions that return the same bits on every machine.
//
// The C library chooses its code for these by the processor (glibc has a copy with fused instructions and one without),
// and each C library rounds in its own way. Nothing that decides a byte of a file may depend on that, so the tools use
// these functions instead of those of <cmath>; scripts/check_math.py makes sure. They are built from + - * / and square
// roots, which IEEE 754 leaves no choice, and need what all our code needs: no contraction, no fast-math, binary64
// arithmetic. std::sqrt, fma, fmod, remainder, floor, ldexp and the like are exact or rounded correctly everywhere.
//
// Largest errors, in units in the last place of the result: logarithms 0.52, atan2 0.6, pow 0.75, exp 0.8, sine and
// cosine 0.85, hypot 1.4, acos 1.7, tan 2.1. tests/unit/formats/math measures them.
//
// Sums of two doubles: [Dekker 1971]. Reduction of angles: [Cody, Waite 1980].
#pragma once

namespace dgm::math {

/// e^x: 0 below -745.2, infinity above 709.79.
[[nodiscard]] double exp(double x) noexcept;
/// Natural logarithm: -infinity for 0, NaN below 0.
[[nodiscard]] double log(double x) noexcept;
/// Logarithms to the bases 2 and 10; exact for powers of 2 and, up to 10^22, of 10.
[[nodiscard]] double log2(double x) noexcept;
[[nodiscard]] double log10(double x) noexcept;
/// x^y for x >= 0; NaN for x < 0. 1 if y is 0 or x is 1.
[[nodiscard]] double pow(double x, double y) noexcept;

struct SineCosine {
    double sine, cosine;
};
/// Both of an angle in radians. Beyond a million the angle is taken modulo the double nearest to 2 pi, so that the
/// result is off by about 4e-17 times the angle. NaN for infinities.
[[nodiscard]] SineCosine sine_cosine(double angle) noexcept;
[[nodiscard]] inline double sin(double angle) noexcept {
    return sine_cosine(angle).sine;
}
[[nodiscard]] inline double cos(double angle) noexcept {
    return sine_cosine(angle).cosine;
}
[[nodiscard]] inline double tan(double angle) noexcept {
    const SineCosine both = sine_cosine(angle);
    return both.sine / both.cosine;
}

/// Angle of (x, y), in [-pi, pi]; signed zeros and infinities as in C.
[[nodiscard]] double atan2(double y, double x) noexcept;
/// In [0, pi]; NaN outside [-1, 1].
[[nodiscard]] double acos(double x) noexcept;

/// sqrt(x^2 + y^2) without overflow or underflow between.
[[nodiscard]] double hypot(double x, double y) noexcept;
[[nodiscard]] double hypot(double x, double y, double z) noexcept;

}  // namespace dgm::math
