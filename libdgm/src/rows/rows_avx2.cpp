// SPDX-License-Identifier: MIT
// libdgm/src/rows/rows_avx2.cpp
// Eight lanes. Built for AVX2 function by function, without compiler flags; runs only where the processor has it.
#include <cstddef>

#include "rows/rows.h"

#if DGM_HAS_AVX
#include <immintrin.h>

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2,fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma")
#endif

namespace dgm::detail {
namespace {
#define DGM_LANES 8
typedef float Floats __attribute__((vector_size(32)));
typedef float Floats4 __attribute__((vector_size(16)));
typedef int Ints __attribute__((vector_size(32)));

static DGM_INLINE Floats root(const Floats& v) {
    return static_cast<Floats>(_mm256_sqrt_ps(static_cast<__m256>(v)));
}
static DGM_INLINE Floats gather(const float* from, const Ints& at) {
    return static_cast<Floats>(_mm256_i32gather_ps(from, reinterpret_cast<__m256i>(at), 4));
}
inline bool any(Ints v) {
    return _mm256_movemask_ps(reinterpret_cast<__m256>(v)) != 0;
}
static DGM_INLINE std::uint32_t sign_bits(const Ints& v) {
    return static_cast<std::uint32_t>(_mm256_movemask_ps(reinterpret_cast<__m256>(v)));
}
static DGM_INLINE bool any(int v) {
    return v != 0;
}
static DGM_INLINE int widen(const std::uint8_t* p, int) {
    return *p;
}
template <int kBit>
static DGM_INLINE float choose_bit(int ring, float a, float b) {
    return (ring >> kBit & 1) != 0 ? a : b;
}
static DGM_INLINE Ints widen(const std::uint8_t* p, Ints) {
    return reinterpret_cast<Ints>(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p))));
}
template <int kBit>
static DGM_INLINE Floats choose_bit(const Ints& ring, const Floats& a, const Floats& b) {
    const Ints sign = ring << (31 - kBit);
    return static_cast<Floats>(
        _mm256_blendv_ps(static_cast<__m256>(b), static_cast<__m256>(a), reinterpret_cast<__m256>(sign)));
}
#define DGM_FUSED(name, vector, scalar)                                                \
    static DGM_INLINE Floats name(const Floats& a, const Floats& b, const Floats& c) { \
        return static_cast<Floats>(vector);                                            \
    }                                                                                  \
    static DGM_INLINE float name(float a, float b, float c) {                          \
        return scalar;                                                                 \
    }
DGM_FUSED(multiply_add, _mm256_fmadd_ps(a, b, c), __builtin_fmaf(a, b, c))
DGM_FUSED(multiply_subtract, _mm256_fmsub_ps(a, b, c), __builtin_fmaf(a, b, -c))
DGM_FUSED(subtract_product, _mm256_fnmadd_ps(b, c, a), __builtin_fmaf(-b, c, a))
#undef DGM_FUSED
// Estimate and one Newton step, y (3 - v y^2) / 2: relative error below 3e-7, a third of the time of root and division.
static DGM_INLINE Floats inverse_root(const Floats& v) {
    const Floats y = static_cast<Floats>(_mm256_rsqrt_ps(static_cast<__m256>(v)));
    return 0.5f * y * subtract_product(Floats{} + 3.0f, v * y, y);
}
static DGM_INLINE float inverse_root(float v) {
    const float y = _mm_cvtss_f32(_mm_rsqrt_ps(_mm_set1_ps(v)));
    return 0.5f * y * subtract_product(3.0f, v * y, y);
}
#include "rows/rows_impl.h"
//
#include "rows/patch_rows_impl.h"
}  // namespace

extern const RowKernels kAvx2Rows;
const RowKernels kAvx2Rows{"avx2",     move,       relax,  normals, nearest, bounds,     merge,
                           quad_boxes, boxes_near, chords, profile, rings,   move_patch, press};

}  // namespace dgm::detail

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
