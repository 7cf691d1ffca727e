// SPDX-License-Identifier: MIT
// libdgm/src/rows/contact_rows_avx2.cpp
// Built for AVX2 function by function, as rows_avx2.cpp. Sums may be fused; projecting, weights and bulging are not,
// and round alike.
#include <cstddef>

#include "rows/contact_rows.h"

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
typedef double Doubles __attribute__((vector_size(32)));
typedef long long Longs __attribute__((vector_size(32)));
typedef float Wide __attribute__((vector_size(32)));
typedef int WideInts __attribute__((vector_size(32)));

constexpr bool kFourDoubles = true;
static DGM_INLINE Doubles load_four(const float* p) {
    return static_cast<Doubles>(_mm256_cvtps_pd(_mm_loadu_ps(p)));
}
static DGM_INLINE void store_four(float* p, const Doubles& v) {
    _mm_storeu_ps(p, _mm256_cvtpd_ps(static_cast<__m256d>(v)));
}
static DGM_INLINE Longs four_bytes(const std::uint8_t* p) {
    return reinterpret_cast<Longs>(_mm256_cvtepu8_epi64(_mm_loadu_si32(p)));
}
static DGM_INLINE WideInts wide_bytes(const std::uint8_t* p) {
    return reinterpret_cast<WideInts>(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p))));
}
static DGM_INLINE bool any_lane(const WideInts& v) {
    return _mm256_movemask_ps(reinterpret_cast<__m256>(v)) != 0;
}
static DGM_INLINE void add_to(const Wide& v, Doubles& sums) {
    const __m256 w = static_cast<__m256>(v);
    sums += static_cast<Doubles>(_mm256_cvtps_pd(_mm256_castps256_ps128(w))) +
            static_cast<Doubles>(_mm256_cvtps_pd(_mm256_extractf128_ps(w, 1)));
}
static DGM_INLINE Wide square_root(const Wide& v) {
    return static_cast<Wide>(_mm256_sqrt_ps(static_cast<__m256>(v)));
}
static DGM_INLINE Doubles square_root(const Doubles& v) {
    return static_cast<Doubles>(_mm256_sqrt_pd(static_cast<__m256d>(v)));
}
static DGM_INLINE double square_root(double v) {
    return _mm_cvtsd_f64(_mm_sqrt_sd(_mm_setzero_pd(), _mm_set_sd(v)));
}
static DGM_INLINE unsigned lane_bits(const Longs& v) {
    return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(v)));
}
// fmadd: a b + c, fmsub: a b - c, fnmadd: c - a b.
#define DGM_FUSED(type, suffix)                                                                                    \
    static DGM_INLINE type multiply_add(const type& a, const type& b, const type& c) {                             \
        return static_cast<type>(_mm256_fmadd_##suffix(a, b, c));                                                  \
    }                                                                                                              \
    static DGM_INLINE type multiply_subtract(const type& a, const type& b, const type& c) {                        \
        return static_cast<type>(_mm256_fmsub_##suffix(a, b, c));                                                  \
    }                                                                                                              \
    static DGM_INLINE __attribute__((unused)) type subtract_product(const type& c, const type& a, const type& b) { \
        return static_cast<type>(_mm256_fnmadd_##suffix(a, b, c));                                                 \
    }
DGM_FUSED(Wide, ps)
DGM_FUSED(Doubles, pd)
#undef DGM_FUSED
#include "rows/contact_rows_impl.h"
}  // namespace

extern const ContactRows kAvx2ContactRows;
const ContactRows kAvx2ContactRows{volume,   swept,  cubic,   area,   mark,      exchange,
                                   put_back, smooth, weights, spread, held_back, bulge};

}  // namespace dgm::detail

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
