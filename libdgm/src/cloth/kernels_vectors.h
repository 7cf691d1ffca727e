// SPDX-License-Identifier: MIT
// libdgm/src/cloth/kernels_vectors.h
// Vectors of one number of lanes. Included by kernels_impl.h.

#include "rows/vectors.h"

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
