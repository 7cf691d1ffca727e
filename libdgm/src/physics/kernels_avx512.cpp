// SPDX-License-Identifier: MIT
// libdgm/src/physics/kernels_avx512.cpp
// Sixteen lanes. Built for AVX-512 function by function, without compiler flags; runs only where the processor has it.
#include "physics/kernels.h"

#include "rows/rows.h"

#if DGM_HAS_AVX
#include <immintrin.h>

#include "base/inline.h"

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx512f,avx512vl,avx512dq"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx512vl,avx512dq")
#endif

namespace dgm::detail::physics {
namespace {
typedef float Floats __attribute__((vector_size(64)));
typedef int Ints __attribute__((vector_size(64)));
constexpr int kLanes = 16;
static DGM_INLINE Floats root(const Floats& v) {
    return static_cast<Floats>(_mm512_maskz_sqrt_ps(0xFFFF, static_cast<__m512>(v)));
}
// The compiler makes two halves of this.
#define DGM_WIDE_LOAD
static DGM_INLINE __m512d eight_doubles(const float* from) {
    return _mm512_maskz_cvtps_pd(0xff, _mm256_loadu_ps(from));  // unmasked, GCC 12 warns of its own header
}
#define DGM_WIDEN
static DGM_INLINE Floats widened(const std::int16_t* from) {
    const __m256i s = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
    return static_cast<Floats>(_mm512_maskz_cvtepi32_ps(0xffff, _mm512_maskz_cvtepi16_epi32(0xffff, s)));
}
#include "physics/kernels_impl.h"
// Needs the former.
#include "physics/kernels_factor.h"
}  // namespace

extern const Kernels kAvx512Kernels;
const Kernels kAvx512Kernels{"avx512", sweep,        near,     quads,  stretches, twist,           bend,
                             gather,   gather_areas, add,      weigh,  turn,      blend,           inner,
                             total,    place,        diagonal, volume, solve,     subtract_product};

}  // namespace dgm::detail::physics

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
