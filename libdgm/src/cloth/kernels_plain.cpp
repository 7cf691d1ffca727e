// SPDX-License-Identifier: MIT
// libdgm/src/cloth/kernels_plain.cpp
// Four lanes on whatever the target has, and the choice at run time.
#include "cloth/kernels.h"

#include "base/inline.h"
#include "rows/four_roots.h"
#include "rows/rows.h"

// Vectors go by value between functions of this file alone, so the calling convention of a target without SSE does not
// matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace dgm::detail::cloth {
namespace {
typedef float Floats __attribute__((vector_size(16)));
constexpr int kLanes = 4;
static DGM_INLINE Floats root(Floats v) {
    take_roots(v);
    return v;
}
#include "cloth/kernels_impl.h"
}  // namespace

const Kernels kPlainKernels{"plain", force, products, diagonal,    invert,         sweep, add,     start,
                            finish,  move,  shape,    restrict_to, interpolate_to, thin,  stiffen, inner};

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

}  // namespace dgm::detail::cloth
