// SPDX-License-Identifier: MIT
// libdgm/src/rows/four_roots.h
// Square roots of four floats in one instruction, where the target has one. Rounded correctly by all of them.
#pragma once
#if defined(__SSE__)
#include <xmmintrin.h>
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

#include "base/inline.h"

namespace dgm::detail {

typedef float FourFloats __attribute__((vector_size(16)));

/// In place, so that the calling convention of a target without SSE does not matter.
static DGM_INLINE void take_roots(FourFloats& v) {
#if defined(__SSE__)
    v = static_cast<FourFloats>(_mm_sqrt_ps(static_cast<__m128>(v)));
#elif defined(__wasm_simd128__)
    v = reinterpret_cast<FourFloats>(wasm_f32x4_sqrt(reinterpret_cast<v128_t>(v)));
#elif defined(__aarch64__)
    v = reinterpret_cast<FourFloats>(vsqrtq_f32(reinterpret_cast<float32x4_t>(v)));
#else
    v = FourFloats{__builtin_sqrtf(v[0]), __builtin_sqrtf(v[1]), __builtin_sqrtf(v[2]), __builtin_sqrtf(v[3])};
#endif
}

}  // namespace dgm::detail
