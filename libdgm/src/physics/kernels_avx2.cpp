// SPDX-License-Identifier: MIT
// libdgm/src/physics/kernels_avx2.cpp
// Eight lanes. Built for AVX2 function by function, without compiler flags; runs only where the processor has it.
#include "physics/kernels.h"

#include "rows/rows.h"

#if DGM_HAS_AVX
#include <immintrin.h>

#include "base/inline.h"

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif

namespace dgm::detail::physics {
namespace {
typedef float Floats __attribute__((vector_size(32)));
typedef int Ints __attribute__((vector_size(32)));
constexpr int kLanes = 8;
static DGM_INLINE Floats root(const Floats& v) {
    return static_cast<Floats>(_mm256_sqrt_ps(static_cast<__m256>(v)));
}
#define DGM_WIDEN
static DGM_INLINE Floats widened(const std::int16_t* from) {
    const __m128i s = _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
    return static_cast<Floats>(_mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(s)));
}
#include "physics/kernels_impl.h"
// Needs the former.
#include "physics/kernels_factor.h"
}  // namespace

extern const Kernels kAvx2Kernels;
const Kernels kAvx2Kernels{"avx2", sweep,        near,     quads,  stretches, twist,           bend,
                           gather, gather_areas, add,      weigh,  turn,      blend,           inner,
                           total,  place,        diagonal, volume, solve,     subtract_product};

}  // namespace dgm::detail::physics

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
