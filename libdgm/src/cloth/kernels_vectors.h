// SPDX-License-Identifier: MIT
// libdgm/src/cloth/kernels_vectors.h
// Vectors of one number of lanes. Included by kernels_impl.h.

static DGM_INLINE Floats load(const float* from) {
    Floats v;
    __builtin_memcpy(&v, from, sizeof v);
    return v;
}
static DGM_INLINE void store(float* to, const Floats& v) {
    __builtin_memcpy(to, &v, sizeof v);
}
static DGM_INLINE Floats all(float v) {
    return Floats{} + v;
}
static DGM_INLINE Floats larger(const Floats& a, const Floats& b) {
    return a > b ? a : b;
}

struct V3 {
    Floats x, y, z;
};
static DGM_INLINE V3 operator+(const V3& a, const V3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
static DGM_INLINE V3 operator-(const V3& a, const V3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
static DGM_INLINE V3 operator*(const Floats& s, const V3& a) {
    return {s * a.x, s * a.y, s * a.z};
}
static DGM_INLINE V3 operator*(float s, const V3& a) {
    return {s * a.x, s * a.y, s * a.z};
}
static DGM_INLINE Floats dot(const V3& a, const V3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static DGM_INLINE V3 cross(const V3& a, const V3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static DGM_INLINE V3 load(const Field& f, std::ptrdiff_t s) {
    return {load(f.p[0] + s), load(f.p[1] + s), load(f.p[2] + s)};
}
static DGM_INLINE void store(const Field& f, std::ptrdiff_t s, const V3& v) {
    store(f.p[0] + s, v.x);
    store(f.p[1] + s, v.y);
    store(f.p[2] + s, v.z);
}

/// Eight doubles whatever the number of lanes: their sum then has the same parts.
typedef double Doubles __attribute__((vector_size(64)));
typedef float Eight __attribute__((vector_size(32)));
static DGM_INLINE Doubles eight_at(const float* from) {
    Eight v;
    __builtin_memcpy(&v, from, sizeof v);
    return __builtin_convertvector(v, Doubles);
}
static DGM_INLINE void put_eight(float* to, const Doubles& from) {
    const Eight v = __builtin_convertvector(from, Eight);
    __builtin_memcpy(to, &v, sizeof v);
}
static DGM_INLINE void widen_add(Doubles& sum, const float* from) {
    sum += eight_at(from);
}
static DGM_INLINE double sum_of(const Doubles& v) {
    return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

#include "rows/pairs.h"

static DGM_INLINE V3 left_of(const V3& before, const V3& here) {
    return {Pairs::left(before.x, here.x), Pairs::left(before.y, here.y), Pairs::left(before.z, here.z)};
}
