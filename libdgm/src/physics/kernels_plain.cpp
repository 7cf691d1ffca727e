// SPDX-License-Identifier: MIT
// libdgm/src/physics/kernels_plain.cpp
// Four lanes on whatever the target has, and the choice at run time.
#include "physics/kernels.h"

#include "base/inline.h"
#include "rows/four_roots.h"
#include "rows/rows.h"

// Vectors go by value between functions of this file alone, so the calling convention of a target without SSE does not
// matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace dgm::detail::physics {
namespace {
typedef float Floats __attribute__((vector_size(16)));
typedef int Ints __attribute__((vector_size(16)));
constexpr int kLanes = 4;
static DGM_INLINE Floats root(Floats v) {
    take_roots(v);
    return v;
}
#include "physics/kernels_impl.h"
#ifdef DGM_NO_FACTORS
#define DGM_FACTOR_LOOPS nullptr, nullptr
#else
#include "physics/kernels_factor.h"
#define DGM_FACTOR_LOOPS solve, subtract_product
#endif
}  // namespace

const Kernels kPlainKernels{"plain", sweep, near,  quads, stretches, twist, bend,     gather, gather_areas,    add,
                            weigh,   turn,  blend, inner, total,     place, diagonal, volume, DGM_FACTOR_LOOPS};

#if DGM_HAS_AVX
extern const Kernels kAvx2Kernels, kAvx512Kernels;
#endif

const Kernels& choose_kernels(bool plain) noexcept {
#if DGM_HAS_AVX
    __builtin_cpu_init();
    if (!plain && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512dq"))
        return kAvx512Kernels;
    if (!plain && __builtin_cpu_supports("avx2")) return kAvx2Kernels;
#else
    static_cast<void>(plain);
#endif
    return kPlainKernels;
}

}  // namespace dgm::detail::physics
