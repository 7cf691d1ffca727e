// SPDX-License-Identifier: MIT
// libdgm/src/cloth/kernels_avx512.cpp
// Sixteen lanes. Built for AVX-512 function by function, without compiler flags; runs only where the processor has it.
#include "cloth/kernels.h"

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

namespace dgm::detail::cloth {
namespace {
typedef float Floats __attribute__((vector_size(64)));
constexpr int kLanes = 16;
static DGM_INLINE Floats root(const Floats& v) {
    return static_cast<Floats>(_mm512_maskz_sqrt_ps(0xFFFF, static_cast<__m512>(v)));
}
#include "cloth/kernels_impl.h"
}  // namespace

extern const Kernels kAvx512Kernels;
const Kernels kAvx512Kernels{"avx512", force, products, diagonal,    invert,         sweep, add,     start,
                             finish,   move,  shape,    restrict_to, interpolate_to, thin,  stiffen, inner};

}  // namespace dgm::detail::cloth

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
