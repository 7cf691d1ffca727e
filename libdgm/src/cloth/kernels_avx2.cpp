// SPDX-License-Identifier: MIT
// libdgm/src/cloth/kernels_avx2.cpp
// Eight lanes. Built for AVX2 function by function, without compiler flags; runs only where the processor has it.
#include "cloth/kernels.h"

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

// Eight doubles are two registers here; they go between functions of this file alone.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace dgm::detail::cloth {
namespace {
typedef float Floats __attribute__((vector_size(32)));
constexpr int kLanes = 8;
static DGM_INLINE Floats root(const Floats& v) {
    return static_cast<Floats>(_mm256_sqrt_ps(static_cast<__m256>(v)));
}
#include "cloth/kernels_impl.h"
}  // namespace

extern const Kernels kAvx2Kernels;
const Kernels kAvx2Kernels{"avx2", force, products, diagonal,    invert,         sweep, add,     start,
                           finish, move,  shape,    restrict_to, interpolate_to, thin,  stiffen, inner};

}  // namespace dgm::detail::cloth

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
