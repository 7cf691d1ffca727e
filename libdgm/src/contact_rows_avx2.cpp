// SPDX-License-Identifier: MIT
// libdgm/src/contact_rows_avx2.cpp
// Built for AVX2 function by function, as rows_avx2.cpp. Nothing is fused: projecting and bulging round alike.
#include <cstddef>

#include "contact_rows.h"

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif

namespace dgm::detail {
namespace {
typedef double Doubles __attribute__((vector_size(32)));
typedef long long Longs __attribute__((vector_size(32)));
typedef float Single4 __attribute__((vector_size(16)));
typedef float Wide __attribute__((vector_size(32)));
typedef int Int4 __attribute__((vector_size(16)));

static inline __attribute__((always_inline)) Doubles load_four(const float* p) {
    return static_cast<Doubles>(_mm256_cvtps_pd(_mm_loadu_ps(p)));
}
static inline __attribute__((always_inline)) void store_four(float* p, const Doubles& v) {
    _mm_storeu_ps(p, _mm256_cvtpd_ps(static_cast<__m256d>(v)));
}
static inline __attribute__((always_inline)) Longs four_bytes(const std::uint8_t* p) {
    return reinterpret_cast<Longs>(_mm256_cvtepu8_epi64(_mm_loadu_si32(p)));
}
static inline __attribute__((always_inline)) Doubles four_roots(const Doubles& v) {
    return static_cast<Doubles>(_mm256_sqrt_pd(static_cast<__m256d>(v)));
}
#include "contact_rows_impl.h"
}  // namespace

extern const ContactRows kAvx2ContactRows;
const ContactRows kAvx2ContactRows{volume, cubic, area, mark, project, weights, bulge};

}  // namespace dgm::detail

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
