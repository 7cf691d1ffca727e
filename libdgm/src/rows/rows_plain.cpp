// SPDX-License-Identifier: MIT
// libdgm/src/rows/rows_plain.cpp
// Four lanes on whatever the target has, and the choice at run time.
#include <cstddef>

#include "rows/four_roots.h"
#include "rows/rows.h"

// Vectors go by value between functions of this file alone, so the calling convention of a target without SSE does not
// matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace dgm::detail {
namespace {
#define DGM_LANES 4
typedef float Floats __attribute__((vector_size(16)));
typedef Floats Floats4;
typedef int Ints __attribute__((vector_size(16)));

static DGM_INLINE Floats inverse_root(Floats v) {
    take_roots(v);
    return 1.0f / v;
}
static DGM_INLINE Floats root(Floats v) {
    take_roots(v);
    return v;
}
static DGM_INLINE Floats gather(const float* from, const Ints& at) {
    return Floats{from[at[0]], from[at[1]], from[at[2]], from[at[3]]};
}
static DGM_INLINE bool any(Ints v) {
    return (v[0] | v[1] | v[2] | v[3]) != 0;
}
static DGM_INLINE std::uint32_t sign_bits(const Ints& v) {
    return static_cast<std::uint32_t>((v[0] & 1) | (v[1] & 2) | (v[2] & 4) | (v[3] & 8));
}
static DGM_INLINE float inverse_root(float v) {
    return 1.0f / __builtin_sqrtf(v);
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
inline Ints widen(const std::uint8_t* p, Ints) {
    return Ints{p[0], p[1], p[2], p[3]};
}
template <int kBit>
inline Floats choose_bit(const Ints& ring, const Floats& a, const Floats& b) {
    return (ring & (1 << kBit)) != 0 ? a : b;
}
#include "rows/unfused.h"
// The bodies, which need all of the above.
#include "rows/rows_impl.h"
//
#include "rows/patch_rows_impl.h"
}  // namespace

const RowKernels kPlainRows{"plain",    move,       relax,  normals, nearest, bounds,     merge,
                            quad_boxes, boxes_near, chords, profile, rings,   move_patch, press};

#if DGM_HAS_AVX
extern const RowKernels kAvx2Rows;
extern const NormalLoops kAvx512Normals;
#endif

const RowKernels& choose_rows(bool plain) noexcept {
#if DGM_HAS_AVX
    __builtin_cpu_init();
    if (!plain && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return kAvx2Rows;
#else
    static_cast<void>(plain);
#endif
    return kPlainRows;
}

NormalLoops choose_normals(const RowKernels& rows, const std::uint8_t* ring, float scale) noexcept {
#if DGM_HAS_AVX
    if (&rows == &kAvx2Rows && ring == nullptr && scale == 1 && __builtin_cpu_supports("avx512f") &&
        __builtin_cpu_supports("avx512vl"))
        return kAvx512Normals;
#else
    static_cast<void>(ring);
    static_cast<void>(scale);
#endif
    return rows.normals;
}

}  // namespace dgm::detail
