// SPDX-License-Identifier: GPL-3.0-or-later
/* tests/exact/rough_maths.c
 * Put before libm with LD_PRELOAD: another C library, whose transcendental functions are off in the last place. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

/* The next double away from zero for some results, the result itself for others. */
static double rough(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    if (value != 0 && isfinite(value) && bits * UINT64_C(0x9E3779B97F4A7C15) >> 63) ++bits;
    memcpy(&value, &bits, sizeof value);
    return value;
}
static float roughf(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    if (value != 0 && isfinite(value) && bits * UINT32_C(0x9E3779B1) >> 31) ++bits;
    memcpy(&value, &bits, sizeof value);
    return value;
}

#define FROM_LIBRARY(type, name, ...) \
    static type (*real)(__VA_ARGS__); \
    if (!real) *(void**)&real = dlsym(RTLD_NEXT, #name)
#define OF_ONE(name)                         \
    double name(double x) {                  \
        FROM_LIBRARY(double, name, double);  \
        return rough(real(x));               \
    }                                        \
    float name##f(float x) {                 \
        FROM_LIBRARY(float, name##f, float); \
        return roughf(real(x));              \
    }
#define OF_TWO(name)                                \
    double name(double x, double y) {               \
        FROM_LIBRARY(double, name, double, double); \
        return rough(real(x, y));                   \
    }                                               \
    float name##f(float x, float y) {               \
        FROM_LIBRARY(float, name##f, float, float); \
        return roughf(real(x, y));                  \
    }

OF_ONE(exp)
OF_ONE(exp2)
OF_ONE(expm1)
OF_ONE(log)
OF_ONE(log2)
OF_ONE(log10)
OF_ONE(log1p)
OF_ONE(sin)
OF_ONE(cos)
OF_ONE(tan)
OF_ONE(asin)
OF_ONE(acos)
OF_ONE(atan)
OF_ONE(sinh)
OF_ONE(cosh)
OF_ONE(tanh)
OF_ONE(cbrt)
OF_TWO(atan2)
OF_TWO(pow)
OF_TWO(hypot)

void sincos(double x, double* sine, double* cosine) {
    *sine = sin(x);
    *cosine = cos(x);
}
void sincosf(float x, float* sine, float* cosine) {
    *sine = sinf(x);
    *cosine = cosf(x);
}
